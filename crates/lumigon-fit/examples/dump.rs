use lumigon_fit::*;
use std::sync::atomic::AtomicBool;
fn main() {
    let settings = Settings {
        size: 16,
        cosine: std::env::args().nth(1).is_some(),
        ..Settings::default()
    };
    let table = fit(&settings, &|_, _| (), &AtomicBool::new(false)).unwrap();
    let ch = table.channel_count();
    for c in [3, 5, 7, 9, 12, 15] {
        println!("column {c}");
        for r in 0..16 {
            let t = &table.texels()[ch * (r * 16 + c)..][..ch];
            println!("  {r}: {:.3?}", t);
        }
    }
}
