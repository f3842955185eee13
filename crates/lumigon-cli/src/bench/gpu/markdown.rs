//! The figures as Markdown tables.

use std::fmt::Write;

use super::images::ImageFigures;
use super::{COMPARED_LIGHTS, COUNTS, Figures, LightFigures};
use crate::bench::images::FilterFigures;

/// All figures as tables, each under its heading.
pub(super) fn markdown(figures: &Figures) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut text, figures);
    text
}

fn write(out: &mut String, figures: &Figures) -> std::fmt::Result {
    let device = &figures.device;
    writeln!(
        out,
        "GPU: {} ({}, {}, {}). Multiply-adds: {:.1} billion a second; copying: {:.1} GB a second. \
         Timed by {}.",
        device.name,
        device.kind,
        device.backend,
        device.driver,
        device.giga_fma_per_second,
        device.giga_bytes_per_second,
        device.clock,
    )?;
    writeln!(
        out,
        "\n### Milliseconds a light, by number of lights, 1440x900\n\nIn brackets: times the floor.\n"
    )?;
    write!(out, "| shading | vertices |")?;
    for count in COUNTS {
        write!(out, " {count} |")?;
    }
    writeln!(out, "\n| --- | ---: |{}", " ---: |".repeat(COUNTS.len()))?;
    for row in figures.lights.chunks(COUNTS.len()) {
        let Some(first) = row.first() else { continue };
        write!(out, "| {} | {} |", first.shading.name(), first.vertices)?;
        for LightFigures {
            milliseconds_a_light,
            times_the_floor,
            ..
        } in row
        {
            let time = significant(*milliseconds_a_light);
            write!(out, " {time} ({times_the_floor:.1}) |")?;
        }
        writeln!(out)?;
    }
    let smaller = |light: &LightFigures| light.measured_width < super::lighting::WIDTH;
    if figures.lights.iter().any(smaller) {
        writeln!(
            out,
            "\nScaled from smaller frames where 1440x900 took too long; the JSON has their sizes."
        )?;
    }
    writeln!(
        out,
        "\n### Beside common practice, {COMPARED_LIGHTS} lights\n"
    )?;
    writeln!(
        out,
        "| method | shading | vertices | light | ms a light | exact over this | worst error | RMS \
         error |\n| --- | --- | ---: | --- | ---: | ---: | ---: | ---: |"
    )?;
    for method in &figures.methods {
        writeln!(
            out,
            "| {} | {} | {} | {} | {} | {:.2} | {:.1e} | {:.1e} |",
            method.method,
            method.shading.name(),
            method.vertices,
            method.placement,
            significant(method.milliseconds_a_light),
            method.exact_over_this,
            method.greatest_error,
            method.rms_error,
        )?;
    }
    writeln!(out, "\n### Many small lights\n")?;
    writeln!(
        out,
        "| lights | light bound | frame | ms | over the fewest | clock |\n\
         | ---: | ---: | ---: | ---: | ---: | --- |"
    )?;
    for many in &figures.many_lights {
        writeln!(
            out,
            "| {} | {} | {}x{} | {} | {:.2} | {} |",
            many.lights,
            many.light_bound,
            many.width,
            many.height,
            significant(many.milliseconds),
            many.ratio,
            many.clock,
        )?;
    }
    write_images(out, &figures.images)
}

fn write_images(out: &mut String, figures: &ImageFigures) -> std::fmt::Result {
    writeln!(
        out,
        "\n### Lights with images\n\nDiffuse light and LTC, by {}.\n\n\
         | image | ns a pixel and light | over no image |\n| --- | ---: | ---: |",
        figures.clock
    )?;
    for light in &figures.lights {
        writeln!(
            out,
            "| {} | {} | {:.2} |",
            light.image_method,
            significant(light.nanoseconds),
            light.ratio
        )?;
    }
    writeln!(
        out,
        "\n### A new image: upload of its bytes and all levels\n\n\
         | image | ms | MB |\n| ---: | ---: | ---: |"
    )?;
    for FilterFigures {
        side,
        milliseconds,
        bytes,
    } in &figures.filtering
    {
        let megabytes = *bytes as f64 * 1e-6;
        let time = significant(*milliseconds);
        writeln!(out, "| {side}x{side} | {time} | {megabytes:.1} |")?;
    }
    Ok(())
}

/// Three digits.
fn significant(value: f64) -> String {
    let digits = match value {
        0.0..0.001 => 6,
        0.001..0.01 => 5,
        0.01..0.1 => 4,
        0.1..1.0 => 3,
        1.0..10.0 => 2,
        10.0..100.0 => 1,
        _ => 0,
    };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::gpu::DeviceFigures;
    use crate::bench::gpu::images::ImageLightFigures;
    use crate::bench::gpu::shading::Shading;

    #[test]
    fn rows_have_as_many_cells_as_their_heads() {
        let light = |lights| LightFigures {
            shading: Shading::Ltc,
            vertices: 4,
            lights,
            measured_width: 45,
            measured_height: 29,
            milliseconds: 12.3,
            milliseconds_a_light: 0.01234,
            operations: 300.0,
            floor_milliseconds: 6.0,
            times_the_floor: 2.05,
        };
        let figures = Figures {
            device: DeviceFigures {
                name: "a GPU".to_owned(),
                kind: "discrete".to_owned(),
                backend: "vulkan".to_owned(),
                driver: "one".to_owned(),
                clock: "timestamp queries",
                empty_submission_microseconds: 10.0,
                giga_fma_per_second: 1e4,
                giga_bytes_per_second: 1e3,
            },
            lights: COUNTS.map(light).into(),
            methods: Vec::new(),
            many_lights: Vec::new(),
            images: ImageFigures {
                clock: "timestamp queries",
                lights: vec![ImageLightFigures {
                    image_method: "2x2",
                    lights: 8,
                    width: 1440,
                    height: 900,
                    nanoseconds: 1.5,
                    ratio: 3.0,
                }],
                filtering: vec![FilterFigures {
                    side: 256,
                    milliseconds: 0.5,
                    bytes: 1_398_096,
                }],
            },
        };
        let text = markdown(&figures);
        assert!(
            text.contains("| diffuse + LTC | 4 | 0.0123 (2.0) |"),
            "{text}"
        );
        assert!(text.contains("| 2x2 | 1.50 | 3.00 |"), "{text}");
        assert!(text.contains("| 256x256 | 0.500 | 1.4 |"), "{text}");
        assert!(text.contains("Scaled from smaller frames"));
        for table in text.split("\n\n").filter(|part| part.starts_with('|')) {
            let cells: Vec<_> = table.lines().map(|l| l.matches('|').count()).collect();
            assert!(cells.iter().all(|&count| count == cells[0]), "{table}");
        }
    }

    #[test]
    fn three_digits() {
        let told = [0.000_123_4, 0.012_34, 1.234, 1234.4].map(significant);
        assert_eq!(told, ["0.000123", "0.0123", "1.23", "1234"]);
    }
}
