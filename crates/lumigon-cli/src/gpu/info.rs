//! `lumigon gpu info`: which GPUs there are, and which would render.

use std::fmt::Write;

use clap::Args;
use lumigon_renderer::{AdapterDescription, Gpu, GpuError, GpuPreference};
use serde::Serialize;

use crate::Failure;

/// Lists the GPUs of this machine, the most capable first, and says which would render
///
/// The exit code is 0 even where there is none.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lumigon gpu info
  lumigon gpu info --json | jq '.gpus[].name'")]
pub(super) struct Info {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Report {
    gpus: Vec<GpuReport>,
    /// What `--backend auto` and `--backend gpu` come to.
    auto: Outcome,
    gpu: Outcome,
}

/// What a choice of backend comes to on this machine.
#[derive(Debug, Serialize)]
struct Outcome {
    /// The GPU's name; none where it is the CPU, or nothing.
    gpu: Option<String>,
    /// Why it is no GPU.
    reason: Option<String>,
}

#[derive(Debug, Serialize)]
struct GpuReport {
    name: String,
    kind: String,
    backend: String,
    driver: String,
    largest_buffer: u64,
    largest_binding: u64,
    storage_buffers: u32,
    largest_texture_side: u32,
    workgroup_threads: u32,
    workgroup_memory: u32,
    timestamps: bool,
    f16: bool,
    float32_filtering: bool,
    subgroups: bool,
}

impl Info {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let report = Report {
            gpus: Gpu::adapters().into_iter().map(GpuReport::new).collect(),
            auto: Outcome::of(Gpu::new(GpuPreference::Hardware)),
            gpu: Outcome::of(Gpu::new(GpuPreference::Any)),
        };
        let text = match self.json {
            true => serde_json::to_string_pretty(&report)? + "\n",
            false => report.text(),
        };
        match std::io::Write::write_all(&mut std::io::stdout().lock(), text.as_bytes()) {
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
            _ => Ok(()),
        }
    }
}

impl Outcome {
    fn of(opened: Result<Gpu, GpuError>) -> Self {
        match opened {
            Ok(gpu) => Self {
                gpu: Some(gpu.adapter().name.clone()),
                reason: None,
            },
            Err(error) => Self {
                gpu: None,
                reason: Some(error.to_string()),
            },
        }
    }
}

impl GpuReport {
    fn new(adapter: AdapterDescription) -> Self {
        Self {
            kind: adapter.kind.to_string(),
            name: adapter.name,
            backend: adapter.backend,
            driver: adapter.driver,
            largest_buffer: adapter.largest_buffer,
            largest_binding: adapter.largest_binding,
            storage_buffers: adapter.storage_buffers,
            largest_texture_side: adapter.largest_texture_side,
            workgroup_threads: adapter.workgroup_threads,
            workgroup_memory: adapter.workgroup_memory,
            timestamps: adapter.has_timestamps,
            f16: adapter.has_f16,
            float32_filtering: adapter.has_float32_filtering,
            subgroups: adapter.has_subgroups,
        }
    }

    /// The features that it has, or has not.
    fn features(&self, present: bool) -> String {
        let features = [
            ("timestamps", self.timestamps),
            ("half precision", self.f16),
            ("float32 filtering", self.float32_filtering),
            ("subgroups", self.subgroups),
        ];
        let named: Vec<_> = features
            .into_iter()
            .filter_map(|(name, has)| (has == present).then_some(name))
            .collect();
        match named.is_empty() {
            true => "nothing".to_owned(),
            false => named.join(", "),
        }
    }
}

impl Report {
    fn text(&self) -> String {
        let mut text = String::new();
        let out = &mut text;
        // Writing to a string cannot fail.
        let _ = match self.gpus.len() {
            0 => writeln!(out, "no GPUs"),
            1 => writeln!(out, "1 GPU"),
            count => writeln!(out, "{count} GPUs"),
        };
        for (index, gpu) in self.gpus.iter().enumerate() {
            let _ = writeln!(out, "  {index}: {}, {}", gpu.name, gpu.kind);
            let _ = writeln!(out, "     {} through {}", gpu.driver, gpu.backend);
            let _ = writeln!(
                out,
                "     buffers up to {}, {} of them in a shader, up to {} each",
                size(gpu.largest_buffer),
                gpu.storage_buffers,
                size(gpu.largest_binding),
            );
            let _ = writeln!(
                out,
                "     textures up to {} texels wide, workgroups of up to {} threads and {}",
                gpu.largest_texture_side,
                gpu.workgroup_threads,
                size(gpu.workgroup_memory.into()),
            );
            let _ = writeln!(
                out,
                "     has {}; lacks {}",
                gpu.features(true),
                gpu.features(false)
            );
        }
        let outcomes = [
            ("auto", &self.auto, "the CPU"),
            ("gpu", &self.gpu, "nothing"),
        ];
        for (choice, outcome, otherwise) in outcomes {
            let name = outcome.gpu.as_deref().unwrap_or(otherwise);
            let _ = write!(out, "--backend {choice}: {name}");
            let _ = match &outcome.reason {
                Some(reason) => writeln!(out, ", for {reason}"),
                None => writeln!(out),
            };
        }
        text
    }
}

/// Bytes in a unit that fits.
fn size(bytes: u64) -> String {
    let units = ["bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    let digits = usize::from(value.fract() > 0.05);
    format!("{value:.digits$} {}", units[unit])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        let told = [0, 1023, 32 << 10, 1536 << 20, u64::MAX].map(size);
        assert_eq!(
            told,
            ["0 bytes", "1023 bytes", "32 KiB", "1.5 GiB", "16 EiB"]
        );
    }

    #[test]
    fn no_gpu_is_said_with_its_mend() {
        let none = |preference| {
            Outcome::of(Err(GpuError::NoAdapter {
                preference,
                software: false,
            }))
        };
        let report = Report {
            gpus: Vec::new(),
            auto: none(GpuPreference::Hardware),
            gpu: none(GpuPreference::Any),
        };
        let text = report.text();
        assert!(
            text.starts_with("no GPUs\n--backend auto: the CPU, for "),
            "{text}"
        );
        assert!(text.contains("--backend gpu: nothing, for "), "{text}");
        assert!(text.contains("mesa-vulkan-drivers"), "{text}");
    }
}
