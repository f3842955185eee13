//! What the figures were measured on.

use fearless_simd::Level;
use serde::Serialize;

use super::peak;

/// The processor, in words and in multiply-adds.
#[derive(Serialize)]
pub(super) struct Machine {
    processor: String,
    simd_level: String,
    lanes: usize,
    threads: usize,
    /// Fused multiply-adds, each lane counted, on one thread.
    pub(super) giga_fma_per_second: f64,
    /// On all threads at once.
    pub(super) all_threads_giga_fma_per_second: f64,
}

impl Machine {
    pub(super) fn measure() -> Self {
        let level = format!("{:?}", Level::new());
        Self {
            processor: processor(),
            simd_level: level.split('(').next().unwrap_or_default().to_owned(),
            lanes: peak::lanes(),
            threads: rayon::current_num_threads(),
            giga_fma_per_second: peak::fused_multiply_adds_per_second() * 1e-9,
            all_threads_giga_fma_per_second: rayon::broadcast(|_| {
                peak::fused_multiply_adds_per_second()
            })
            .iter()
            .sum::<f64>()
                * 1e-9,
        }
    }

    pub(super) fn print(&self) {
        println!("processor  {}", self.processor);
        println!(
            "SIMD       {}, {} lanes of f32",
            self.simd_level, self.lanes
        );
        println!(
            "FMA peak   {:.1} G/s on one thread, {:.1} G/s on {}",
            self.giga_fma_per_second, self.all_threads_giga_fma_per_second, self.threads
        );
    }
}

/// The processor's name where the system tells it.
fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    told.lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map_or_else(
            || std::env::consts::ARCH.to_owned(),
            |(_, name)| name.trim().to_owned(),
        )
}
