//! Makes the table that `tables/` ships:
//! `cargo run --release -p lumigon-fit --example fit_ggx -- tables`.
//! Any setting can be given as JSON after the folder, for instance `'{"size": 32}'`.

use std::{path::PathBuf, sync::atomic::AtomicBool, time::Instant};

use lumigon_fit::{Settings, fit};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = PathBuf::from(arguments.first().ok_or("say the folder to write to")?);
    let settings: Settings = arguments
        .get(1)
        .map_or(Ok(Settings::default()), |json| serde_json::from_str(json))?;
    let start = Instant::now();
    let progress = |done: usize, total: usize| {
        if done.is_multiple_of(64) || done == total {
            eprint!("\r{done}/{total}");
        }
    };
    let table = fit(&settings, &progress, &AtomicBool::new(false))?;
    eprintln!("\nfitted in {:.1} s", start.elapsed().as_secs_f64());
    let mut command = "cargo run --release -p lumigon-fit --example fit_ggx -- tables".to_owned();
    if let Some(json) = arguments.get(1) {
        command += &format!(" '{json}'");
    }
    let manifest = table.write(&folder, &command)?;
    println!("{}", serde_json::to_string_pretty(&manifest.errors)?);
    Ok(())
}
