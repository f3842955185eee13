//! Numbers as people read them.

use std::path::Path;

/// The scene's file name without its ending.
pub(crate) fn scene_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or(path.as_os_str());
    stem.to_string_lossy().into_owned()
}

/// A fraction as a percentage of about three digits; a dash for none.
pub(crate) fn percent(fraction: Option<f64>) -> String {
    match fraction.map(|fraction| 100.0 * fraction) {
        None => "–".to_owned(),
        Some(0.0) => "0 %".to_owned(),
        Some(p) if p.abs() < 0.01 => format!("{p:.1e} %"),
        Some(p) if p.abs() < 1.0 => format!("{p:.3} %"),
        Some(p) if p.abs() < 10.0 => format!("{p:.2} %"),
        Some(p) if p.abs() < 100.0 => format!("{p:.1} %"),
        Some(p) if p.abs() < 1e5 => format!("{p:.0} %"),
        Some(p) => format!("{p:.1e} %"),
    }
}

/// Seconds in a unit that suits them.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.0} µs", s * 1e6),
        s if s < 0.01 => format!("{:.2} ms", s * 1e3),
        s if s < 0.1 => format!("{:.1} ms", s * 1e3),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 10.0 => format!("{s:.2} s"),
        s => format!("{s:.1} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_about_three_digits() {
        for (fraction, text) in [
            (0.0, "0 %"),
            (0.000_012_3, "1.2e-3 %"),
            (0.001_23, "0.123 %"),
            (-0.0123, "-1.23 %"),
            (0.123, "12.3 %"),
            (12.3, "1230 %"),
            (52_137.73, "5.2e6 %"),
        ] {
            assert_eq!(percent(Some(fraction)), text);
        }
        assert_eq!(percent(None), "–");
        for (seconds, text) in [
            (1.2e-5, "12 µs"),
            (0.00123, "1.23 ms"),
            (0.0123, "12.3 ms"),
            (0.123, "123 ms"),
            (1.23, "1.23 s"),
            (123.4, "123.4 s"),
        ] {
            assert_eq!(duration(seconds), text);
        }
    }

    #[test]
    fn scenes_are_named_by_their_files() {
        assert_eq!(scene_name("a/gallery.glb".as_ref()), "gallery");
        assert_eq!(scene_name("".as_ref()), "");
    }
}
