//! What can go wrong on a GPU.

use super::GpuPreference;

/// Why the GPU did not do it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// There is no adapter of the kind that was asked for.
    #[error("{}", no_adapter(*preference, *software))]
    NoAdapter {
        /// What was asked for.
        preference: GpuPreference,
        /// Whether there is a software adapter, which would do where any does.
        software: bool,
    },
    /// No adapter that will do can show pictures in the window.
    #[error(
        "the GPU \"{adapter}\" cannot show pictures in this window: show the window on the display that \
         the GPU drives, or use the CPU"
    )]
    CannotPresent {
        /// The name of the one that would do otherwise.
        adapter: String,
    },
    /// An adapter gave no device.
    #[error("the GPU \"{adapter}\" cannot be used: {reason}; update its driver, or use the CPU")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What its driver said.
        reason: String,
    },
    /// The device is gone: its driver was reset or updated, or the GPU was taken out.
    #[error("the GPU was lost: {reason}; start again, or use the CPU")]
    Lost {
        /// What the driver said.
        reason: String,
    },
    /// The device's memory is used up.
    #[error(
        "the GPU has too little memory for {what}: free some, use a smaller scene, or use the CPU"
    )]
    OutOfMemory {
        /// What the memory was for.
        what: &'static str,
    },
    /// One list of the scene is longer than the device's buffers.
    #[error(
        "{count} {what} need a buffer of {needed} bytes, but the GPU's hold {limit}: use fewer, or \
         the CPU"
    )]
    TooMuch {
        /// What the list is of.
        what: &'static str,
        /// How many there are.
        count: u64,
        /// Bytes they need.
        needed: u64,
        /// Bytes that one buffer may have.
        limit: u64,
    },
    /// The lights or their images are more than the device's buffers hold.
    #[error(transparent)]
    Lights(#[from] lumigon_wgpu::LightBuffersError),
    /// The lights' distance fields are more than the device's buffers hold.
    #[error(transparent)]
    TooManyFields(#[from] lumigon_wgpu::TooManyFields),
    /// The device does not finish its work.
    #[error(
        "the GPU has not answered for {seconds} s: its driver may hang; restart it, or use the CPU"
    )]
    NoAnswer {
        /// How long it was waited for.
        seconds: u64,
    },
    /// The driver or wgpu refused what it was given, which it should not have been.
    #[error("the GPU refused {what}: {reason}; use the CPU, and report this")]
    Refused {
        /// What it was asked to do.
        what: &'static str,
        /// What it said.
        reason: String,
    },
}

fn no_adapter(preference: GpuPreference, software: bool) -> &'static str {
    match (preference, software) {
        (GpuPreference::Any, _) => {
            "there is no GPU: install its Vulkan driver or, to render in software, a package such \
             as Debian's mesa-vulkan-drivers; or use the CPU"
        }
        (GpuPreference::Hardware, true) => {
            "there is no hardware GPU, only a software one: install the GPU's Vulkan driver, or \
             use the CPU"
        }
        (GpuPreference::Hardware, false) => {
            "there is no hardware GPU: install its Vulkan driver, or use the CPU"
        }
    }
}
