mod counted;
mod kernels;
mod peak;
use kernels::*;
pub fn run() {
    let peak = peak::fused_multiply_adds_per_second();
    println!("peak {:.1} GFMA/s lanes {}", peak * 1e-9, peak::lanes());
    for (name, k) in kernels() {
        for n in [3, 4, 10] {
            for pl in [Placement::Above, Placement::Clipped] {
                let w = Workload::new(n, pl);
                let ops = w.operations(k);
                let s = w.time_scalar(k);
                let v = w.time_simd(k);
                println!(
                    "{name:26} {n:2} {pl:?} ops {ops:.0} scalar {s:.1} ns simd {v:.2} ns  x{:.1} peak {:.0}%",
                    s / v,
                    100.0 * ops / (v * 1e-9) / peak
                );
            }
        }
    }
}
