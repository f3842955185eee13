//! A GPU that is ready to work, and how it fails.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use pollster::FutureExt;

use super::{AdapterDescription, GpuError, GpuPreference};

/// How long the device may work on one submission. A driver that hangs is otherwise waited for
/// without end; a software one is slow.
const PATIENCE: Duration = Duration::from_secs(600);

/// How often a wait looks whether it was cancelled or the device lost.
const GLANCE: Duration = Duration::from_millis(50);

/// A device and its queue. Clones share them.
#[derive(Clone, Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    wgpu_adapter: wgpu::Adapter,
    adapter: AdapterDescription,
    faults: Arc<Faults>,
}

/// What the device reported outside of any call.
#[derive(Debug, Default)]
struct Faults {
    /// It stays lost.
    lost: Mutex<Option<String>>,
    /// Told once.
    uncaught: Mutex<Option<String>>,
}

/// What ended a wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Waited {
    Done,
    Cancelled,
}

impl Gpu {
    /// The most capable adapter that will do, with all of its limits.
    ///
    /// # Errors
    /// Where there is none, or none that gives a device.
    pub fn new(preference: GpuPreference) -> Result<Self, GpuError> {
        if preference == GpuPreference::Hardware && !may_have_hardware() {
            return Err(GpuError::NoAdapter {
                preference,
                software: false,
            });
        }
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        Self::among(adapters(&instance), preference)
    }

    /// The most capable adapter that will do and shows pictures in a window, with all of its limits: for
    /// windows that lumigon draws into itself.
    ///
    /// # Errors
    /// Where there is none, none of them shows pictures in this window, or none gives a device.
    pub fn for_surface(
        instance: &wgpu::Instance,
        surface: &wgpu::Surface<'_>,
        preference: GpuPreference,
    ) -> Result<Self, GpuError> {
        let all = adapters(instance);
        let presenting = presenting(all, preference, |a| a.is_surface_supported(surface))?;
        Self::among(presenting, preference)
    }

    /// The first of these adapters that will do and gives a device.
    fn among(
        adapters: Vec<(wgpu::Adapter, AdapterDescription)>,
        preference: GpuPreference,
    ) -> Result<Self, GpuError> {
        let mut fault = None;
        let mut software = false;
        for (adapter, description) in adapters {
            if preference == GpuPreference::Hardware && description.is_software() {
                software = true;
                continue;
            }
            match Self::open(adapter, description) {
                Ok(gpu) => return Ok(gpu),
                // The best adapter's reason.
                Err(reason) => _ = fault.get_or_insert(reason),
            }
        }
        Err(fault.unwrap_or(GpuError::NoAdapter {
            preference,
            software,
        }))
    }

    /// Every adapter of this machine, the most capable first.
    #[must_use]
    pub fn adapters() -> Vec<AdapterDescription> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        adapters(&instance).into_iter().map(|(_, d)| d).collect()
    }

    /// What it runs on.
    #[must_use]
    pub fn adapter(&self) -> &AdapterDescription {
        &self.adapter
    }

    /// The device.
    #[must_use]
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The device's queue.
    #[must_use]
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// The adapter it was made of, for who presents with it.
    #[must_use]
    pub fn wgpu_adapter(&self) -> &wgpu::Adapter {
        &self.wgpu_adapter
    }

    /// Why the device is gone, if it is: it stays so, and everything that is asked of it fails. Never
    /// waits; what was submitted before goes first.
    #[must_use]
    pub fn is_lost(&self) -> Option<String> {
        // Losses are told in polls. What a poll returns itself is about waiting.
        _ = self.device.poll(wgpu::PollType::Poll);
        lock(&self.faults.lost).clone()
    }

    fn open(adapter: wgpu::Adapter, description: AdapterDescription) -> Result<Self, GpuError> {
        let wanted = wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::SHADER_F16
            | wgpu::Features::FLOAT32_FILTERABLE
            | wgpu::Features::SUBGROUP;
        let asked = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("lumigon"),
            required_features: adapter.features() & wanted,
            required_limits: adapter.limits(),
            ..Default::default()
        });
        let (device, queue) = asked.block_on().map_err(|fault| GpuError::NoDevice {
            adapter: description.name.clone(),
            reason: fault.to_string(),
        })?;
        let faults = Arc::new(Faults::default());
        let heard = Arc::clone(&faults);
        device.set_device_lost_callback(move |_, reason| set(&heard.lost, reason));
        let heard = Arc::clone(&faults);
        device.on_uncaptured_error(Arc::new(move |fault: wgpu::Error| {
            set(&heard.uncaught, fault.to_string());
        }));
        Ok(Self {
            device,
            queue,
            wgpu_adapter: adapter,
            adapter: description,
            faults,
        })
    }

    /// Whether the device is still there and nothing went wrong unheard.
    ///
    /// # Errors
    /// Where the device is lost or refused its work; the latter is told once.
    pub fn check(&self) -> Result<(), GpuError> {
        if let Some(reason) = &*lock(&self.faults.lost) {
            let reason = reason.clone();
            return Err(GpuError::Lost { reason });
        }
        match lock(&self.faults.uncaught).take() {
            Some(reason) => Err(GpuError::Refused {
                what: "its work",
                reason,
            }),
            None => Ok(()),
        }
    }

    /// Runs what asks the device for `what`, and returns its faults as errors.
    pub(super) fn guarded<T>(
        &self,
        what: &'static str,
        work: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        self.check()?;
        let filters = [
            wgpu::ErrorFilter::Validation,
            wgpu::ErrorFilter::Internal,
            wgpu::ErrorFilter::OutOfMemory,
        ];
        // The last one pushed comes first, also where the work panics.
        let mut scopes = VecDeque::new();
        for filter in filters {
            scopes.push_front(self.device.push_error_scope(filter));
        }
        let result = work();
        let mut fault = None;
        while let Some(scope) = scopes.pop_front() {
            let caught = scope.pop().block_on();
            fault = fault.or(caught);
        }
        // A lost device lets everything fail: that is the reason to name.
        self.check()?;
        let value = result?;
        match fault {
            None => Ok(value),
            Some(wgpu::Error::OutOfMemory { .. }) => Err(GpuError::OutOfMemory { what }),
            Some(fault) => Err(GpuError::Refused {
                what,
                reason: fault.to_string(),
            }),
        }
    }

    /// Waits until the device has done a submission, or `cancelled` says so.
    pub(super) fn wait(
        &self,
        submission: &wgpu::SubmissionIndex,
        cancelled: impl Fn() -> bool,
    ) -> Result<Waited, GpuError> {
        let start = Instant::now();
        loop {
            let polled = self.device.poll(wgpu::PollType::Wait {
                submission_index: Some(submission.clone()),
                timeout: Some(GLANCE),
            });
            self.check()?;
            match polled {
                Ok(_) => return Ok(Waited::Done),
                Err(wgpu::PollError::Timeout) => {}
                Err(fault) => {
                    // A destroyed device takes no submission, and tells so in the next poll.
                    _ = self.device.poll(wgpu::PollType::Poll);
                    self.check()?;
                    return Err(GpuError::Refused {
                        what: "to be waited for",
                        reason: fault.to_string(),
                    });
                }
            }
            if cancelled() {
                return Ok(Waited::Cancelled);
            }
            if start.elapsed() > PATIENCE {
                return Err(GpuError::NoAnswer {
                    seconds: PATIENCE.as_secs(),
                });
            }
        }
    }

    /// Waits as [`Gpu::wait`], then gives `each` the bytes of each slice.
    pub(super) fn read(
        &self,
        submission: &wgpu::SubmissionIndex,
        slices: &[wgpu::BufferSlice<'_>],
        cancelled: impl Fn() -> bool,
        mut each: impl FnMut(usize, &[u8]),
    ) -> Result<Waited, GpuError> {
        for slice in slices {
            // Where mapping fails, so does reading below.
            slice.map_async(wgpu::MapMode::Read, |_| {});
        }
        let mut result = self.wait(submission, cancelled);
        if matches!(result, Ok(Waited::Done)) {
            for (i, slice) in slices.iter().enumerate() {
                match slice.get_mapped_range() {
                    Ok(view) => each(i, &view),
                    Err(fault) => {
                        result = Err(GpuError::Refused {
                            what: "to be read",
                            reason: fault.to_string(),
                        });
                    }
                }
            }
        }
        for slice in slices {
            slice.buffer().unmap();
        }
        result
    }
}

/// Whether this machine could have a hardware GPU: on Linux each driver needs a device file.
///
/// Starting Vulkan to find none takes a while, and lets its layers complain of missing desktops.
fn may_have_hardware() -> bool {
    let files = [
        "/dev/dri",
        "/dev/nvidiactl",
        // Windows' subsystem, and GPUs of phones and boards.
        "/dev/dxg",
        "/dev/kgsl-3d0",
        "/dev/mali0",
        "/dev/nvgpu",
        "/dev/nvhost-ctrl",
        "/dev/pvrsrvkm",
    ];
    !cfg!(target_os = "linux") || files.iter().any(|file| std::path::Path::new(file).exists())
}

/// Those adapters that can show pictures in a window.
fn presenting<A>(
    all: Vec<(A, AdapterDescription)>,
    preference: GpuPreference,
    presents: impl Fn(&A) -> bool,
) -> Result<Vec<(A, AdapterDescription)>, GpuError> {
    let will_do = |description: &AdapterDescription| {
        preference == GpuPreference::Any || !description.is_software()
    };
    let (presenting, others): (Vec<_>, Vec<_>) =
        all.into_iter().partition(|(adapter, _)| presents(adapter));
    if presenting.iter().any(|(_, found)| will_do(found)) {
        return Ok(presenting);
    }
    // Where there is no other either, that is what to say.
    match others.into_iter().find(|(_, found)| will_do(found)) {
        Some((_, found)) => Err(GpuError::CannotPresent {
            adapter: found.name,
        }),
        None => Ok(presenting),
    }
}

/// Every adapter, discrete GPUs first and software last.
fn adapters(instance: &wgpu::Instance) -> Vec<(wgpu::Adapter, AdapterDescription)> {
    let found = instance
        .enumerate_adapters(wgpu::Backends::PRIMARY)
        .block_on();
    let mut adapters: Vec<_> = found
        .into_iter()
        .map(|adapter| {
            let description = AdapterDescription::new(&adapter);
            (adapter, description)
        })
        .collect();
    adapters.sort_by_key(|(_, description)| description.kind);
    adapters
}

fn set(place: &Mutex<Option<String>>, reason: String) {
    lock(place).get_or_insert(reason);
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::AdapterKind;

    #[test]
    fn a_lost_device_is_an_error_and_stays_one() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        gpu.check().unwrap();
        gpu.device.destroy();
        let submission = gpu.queue.submit([]);
        for _ in 0..2 {
            let fault = gpu.wait(&submission, || false).unwrap_err();
            assert!(matches!(fault, GpuError::Lost { .. }), "{fault}");
        }
        let fault = gpu.guarded("a buffer", || Ok(())).unwrap_err();
        assert!(matches!(fault, GpuError::Lost { .. }), "{fault}");
    }

    #[test]
    fn a_loss_is_told_without_waiting() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        assert_eq!(gpu.is_lost(), None);
        assert_eq!(gpu.wgpu_adapter().get_info().name, gpu.adapter().name);
        gpu.clone().device.destroy();
        assert!(gpu.is_lost().is_some());
        assert!(gpu.is_lost().is_some(), "and stays told");
    }

    #[test]
    fn windows_want_adapters_that_present() {
        let description = |name: &str, kind| AdapterDescription {
            name: name.to_owned(),
            kind,
            ..Gpu::adapters().remove(0)
        };
        let all = || {
            vec![
                (true, description("fast", AdapterKind::Discrete)),
                (false, description("slow", AdapterKind::Software)),
            ]
        };
        let names = |found: Result<Vec<(bool, AdapterDescription)>, GpuError>| {
            found.map(|found| found.into_iter().map(|(_, d)| d.name).collect::<Vec<_>>())
        };
        let (any, hardware) = (GpuPreference::Any, GpuPreference::Hardware);
        let is_fast = |&fast: &bool| fast;
        assert_eq!(names(presenting(all(), any, is_fast)).unwrap(), ["fast"]);
        assert_eq!(
            names(presenting(all(), any, |fast| !fast)).unwrap(),
            ["slow"]
        );
        let fault = names(presenting(all(), hardware, |fast| !fast)).unwrap_err();
        let adapter = "fast".to_owned();
        assert_eq!(fault, GpuError::CannotPresent { adapter });
        assert!(names(presenting(all(), any, |_| false)).is_err());
        // There is nothing to say of windows where there is no adapter at all.
        assert_eq!(
            names(presenting(Vec::new(), any, is_fast)).unwrap(),
            [""; 0]
        );
    }

    #[test]
    fn faults_come_back_as_errors() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        let too_large = gpu.device.limits().max_buffer_size + 4;
        let buffer = |size| wgpu::BufferDescriptor {
            label: None,
            size,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        };
        let fault = gpu
            .guarded("a buffer", || {
                Ok(gpu.device.create_buffer(&buffer(too_large)))
            })
            .unwrap_err();
        assert!(
            matches!(
                fault,
                GpuError::Refused {
                    what: "a buffer",
                    ..
                }
            ),
            "{fault}"
        );
        gpu.guarded("a buffer", || Ok(gpu.device.create_buffer(&buffer(4))))
            .unwrap();
    }

    #[test]
    fn hardware_is_never_software() {
        match Gpu::new(GpuPreference::Hardware) {
            Ok(gpu) => assert!(!gpu.adapter().is_software()),
            Err(fault) => assert!(matches!(fault, GpuError::NoAdapter { .. }), "{fault}"),
        }
        assert!(!Gpu::adapters().is_empty(), "install mesa-vulkan-drivers");
    }
}
