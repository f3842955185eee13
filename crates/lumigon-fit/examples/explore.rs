use lumigon_fit::*;
use std::sync::atomic::AtomicBool;
fn main() {
    let only: Vec<String> = std::env::args().skip(1).collect();
    let base = Settings::default();
    let variants = [
        ("base32", base.clone()),
        (
            "base16",
            Settings {
                size: 16,
                ..base.clone()
            },
        ),
        (
            "base24",
            Settings {
                size: 24,
                ..base.clone()
            },
        ),
        (
            "s.2",
            Settings {
                secondary: 0.2,
                ..base.clone()
            },
        ),
        (
            "floor",
            Settings {
                floor: 0.02,
                secondary: 0.2,
                ..base.clone()
            },
        ),
        (
            "cosine",
            Settings {
                cosine: true,
                ..base.clone()
            },
        ),
        (
            "two",
            Settings {
                lobes: 2,
                ..base.clone()
            },
        ),
        (
            "two16",
            Settings {
                lobes: 2,
                size: 16,
                ..base.clone()
            },
        ),
        (
            "charlie",
            Settings {
                brdf: BrdfKind::Charlie,
                ..base.clone()
            },
        ),
        (
            "charliec",
            Settings {
                brdf: BrdfKind::Charlie,
                cosine: true,
                ..base.clone()
            },
        ),
        (
            "charlie2",
            Settings {
                brdf: BrdfKind::Charlie,
                lobes: 2,
                ..base.clone()
            },
        ),
        (
            "eon",
            Settings {
                brdf: BrdfKind::Eon,
                ..base.clone()
            },
        ),
        (
            "eonc",
            Settings {
                brdf: BrdfKind::Eon,
                cosine: true,
                ..base.clone()
            },
        ),
        (
            "aniso",
            Settings {
                brdf: BrdfKind::GgxAnisotropic,
                size: 8,
                samples: 200,
                sweeps: 2,
                ..base.clone()
            },
        ),
    ];
    for (name, settings) in variants {
        if !only.is_empty() && !only.iter().any(|o| o == name) {
            continue;
        }
        let t = std::time::Instant::now();
        let table = fit(&settings, &|_, _| (), &AtomicBool::new(false)).unwrap();
        println!("{name} fit {:.1} s", t.elapsed().as_secs_f64());
        for range in [[0.1, 1.0], [0.02, 0.1]] {
            let e = table.errors(range, 77, 512, 48);
            println!(
                "   {range:?}: rmse {:.5} second {:.5} median {:.4} furnace {:.3?} {:.3?}",
                e.rmse, e.secondary_rmse, e.median_relative, e.furnace, e.dielectric_furnace
            );
        }
    }
}
