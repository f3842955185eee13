//! The tables in `tables/` against their own manifests, and what a renderer relies on between
//! their texels. (Their errors against independent truth are tested in `lumigon`, in f32.)

use std::path::{Path, PathBuf};

use lumigon_fit::{BrdfKind, Ltc, Manifest, Settings, Table, refit};

fn manifest_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../tables/{name}.json"))
}

const SHIPPED: [(&str, BrdfKind, u32); 5] = [
    ("ggx-32", BrdfKind::Ggx, 1),
    ("ggx-2-32", BrdfKind::Ggx, 2),
    ("charlie-32", BrdfKind::Charlie, 1),
    ("eon-32", BrdfKind::Eon, 1),
    ("ggx-anisotropic-16", BrdfKind::GgxAnisotropic, 1),
];

fn table(name: &str) -> Table {
    Table::read(&manifest_path(name)).unwrap()
}

/// Directional albedo.
fn albedo(lobes: &[Ltc]) -> f64 {
    lobes
        .iter()
        .map(|lobe| lobe.amplitude * lobe.share_above_horizon())
        .sum()
}

/// `Table::read` checks length, hash and finiteness.
#[test]
fn manifests_match() {
    for (name, brdf, lobes) in SHIPPED {
        let manifest = Manifest::read(&manifest_path(name)).unwrap();
        let settings = Settings::of(brdf, lobes);
        assert_eq!(&manifest.settings, table(name).settings());
        assert_eq!(
            manifest.settings, settings,
            "{name}: the shipped tables are the default fits"
        );
        assert_eq!(settings.name(), name);
        for word in [
            brdf.name().to_owned(),
            format!("--lobes {lobes} "),
            format!("--size {} ", settings.size),
        ] {
            assert!(manifest.command.contains(&word), "{}", manifest.command);
        }
    }
}

/// The fit still makes these tables.
#[test]
fn texels_refit_to_themselves() {
    for (name, ..) in SHIPPED {
        let table = table(name);
        let sizes = table.sizes();
        let places: Vec<Vec<usize>> = [
            [0.1, 0.3, 0.5, 0.4],
            [0.5, 0.6, 0.4, 0.5],
            [0.9, 0.5, 0.2, 0.8],
        ]
        .iter()
        .map(|place| {
            let at = |(&u, &size): (&f64, &usize)| (u * (size - 1) as f64) as usize;
            place.iter().zip(&sizes).map(at).collect()
        })
        .collect();
        for (position, texel) in places.iter().zip(refit(&table, &places).unwrap()) {
            let (mut index, mut stride) = (0, 1);
            for (&at, &size) in position.iter().zip(&sizes) {
                index += at * stride;
                stride *= size;
            }
            let shipped = &table.texels()[texel.len() * index..][..texel.len()];
            for (i, (again, shipped)) in texel.iter().zip(shipped).enumerate() {
                // One more sweep moves a texel a little, a dim lobe's shape most.
                let most = 0.03 * (1.0 + shipped.abs());
                assert!(
                    (again - shipped).abs() < most,
                    "{name} {position:?}[{i}]: {again} now, {shipped} shipped"
                );
            }
        }
    }
}

/// A white surface in a white furnace reflects what the BRDF itself does, between texels too.
#[test]
fn furnace() {
    for (name, bounds) in [
        ("ggx-32", [0.99, 1.01]),
        ("ggx-2-32", [0.99, 1.01]),
        ("eon-32", [0.98, 1.01]),
    ] {
        let table = table(name);
        let (mut least, mut greatest, mut whitest) = (f64::INFINITY, 0.0_f64, 0.0_f64);
        for i in 0..=20 {
            for j in 0..=20 {
                let perceptual_roughness = 0.1 + 0.9 * f64::from(i) / 20.0;
                let cos_theta = (85.0 * f64::from(j) / 20.0).to_radians().cos();
                let place = [perceptual_roughness, (1.0 - cos_theta).sqrt()];
                let (node, _) = lumigon_fit::Node::new(table.brdf(), &place, 20_000);
                let ratio = albedo(&table.lookup_at(&place)) / node.albedo;
                (least, greatest) = (least.min(ratio), greatest.max(ratio));
            }
        }
        for i in 0..=500 {
            for j in 0..=100 {
                let lobes = table.lookup(f64::from(i) / 500.0, f64::from(j) / 100.0);
                whitest = whitest.max(albedo(&lobes));
                for lobe in &lobes {
                    assert!(lobe.shading_to_cosine.determinant() > 0.0, "{lobe:?}");
                    assert!(lobe.amplitude >= 0.0 && lobe.secondary >= 0.0, "{lobe:?}");
                }
            }
        }
        println!("{name}: furnace {least:.4} to {greatest:.4}, largest albedo {whitest:.6}");
        assert!(
            least > bounds[0] && greatest < bounds[1],
            "{name}: {least} {greatest}"
        );
        assert!(whitest < 1.0 + 1e-6, "{name} makes energy: {whitest}");
    }
}

/// The narrowest lobes peak at the mirrored view, within a tenth of their width, at any view and
/// between texels.
#[test]
fn mirrors_reflect_the_view() {
    let table = table("ggx-32");
    for perceptual_roughness in [0.0, 0.01, 0.013, 0.03] {
        let alpha = f64::max(perceptual_roughness * perceptual_roughness, 1e-4);
        for degrees in [0.0_f64, 3.0, 20.0, 47.3, 71.0, 84.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let lobe = table.lookup(perceptual_roughness, cos)[0];
            let peak = lobe.density(glam::DVec3::new(-sin, 0.0, cos));
            // In the plane of incidence, one width away on either side.
            let beside = [-2.0 * alpha, 2.0 * alpha].map(|by| {
                let (sin, cos) = (degrees.to_radians() + by).sin_cos();
                lobe.density(glam::DVec3::new(-sin, 0.0, cos))
            });
            // 1 / (1 + r^2)^2 at one width: a quarter; a shift by a tenth changes it by 20 %.
            for side in beside {
                assert!(
                    (side / peak - 0.25).abs() < 0.06,
                    "{perceptual_roughness} {degrees}: {}",
                    side / peak
                );
            }
            assert!(lobe.amplitude > 0.97, "{perceptual_roughness} {degrees}");
        }
    }
}

/// The polynomial that `lumigon` embeds is the shipped table's.
#[test]
fn embedded_polynomial_is_the_tables() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tables/ggx-polynomial-6.rs");
    let text = std::fs::read_to_string(path).unwrap();
    let polynomial = table("ggx-32").polynomial(6).unwrap();
    let numbers = |text: &str| -> Vec<f32> {
        text.lines()
            .filter(|line| !line.trim_start().starts_with("//"))
            .flat_map(|line| line.split(['[', ']', ',']))
            .filter_map(|word| word.trim().parse().ok())
            .collect()
    };
    let (shipped, again) = (numbers(&text), numbers(&polynomial.to_rust()));
    assert_eq!(shipped.len(), 8 * 49);
    for (a, b) in shipped.iter().zip(&again) {
        assert!((a - b).abs() < 1e-5 * (1.0 + b.abs()), "{a} {b}");
    }
}
