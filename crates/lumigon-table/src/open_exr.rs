use std::io::Cursor;

use exr::prelude::*;

use crate::description::value_index;
use crate::error::TableError;
use crate::image::TableImage;

/// One layer of f32 channels by name; with four axes a layer `slice-<i2>-<i3>` for each slice.
/// Compressed without loss. The texts are attributes `lumigon-<key>`.
pub(crate) fn encode(image: &TableImage) -> std::result::Result<Vec<u8>, TableError> {
    let names = unique(image.channels());
    let [s2, _] = image.slices();
    let size = Vec2(image.sizes()[0], image.sizes()[1]);
    let channels = image.channels().len();
    let slices = image.values().chunks_exact(size.area() * channels);
    let layers = slices.enumerate().map(|(slice, values)| {
        let samples = |channel: usize| {
            let numbers = values.iter().skip(channel).step_by(channels).copied();
            FlatSamples::F32(numbers.collect())
        };
        let list: SmallVec<[AnyChannel<FlatSamples>; 4]> = names
            .iter()
            .enumerate()
            .map(|(channel, name)| AnyChannel::new(text(name), samples(channel)))
            .collect();
        let mut attributes = LayerAttributes::named(match image.sizes().len() {
            2 => text(image.name()),
            _ => text(format!("slice-{}-{}", slice % s2, slice / s2).as_str()),
        });
        attributes.software_name = Some(text("lumigon"));
        let sizes: Vec<String> = image.sizes().iter().map(ToString::to_string).collect();
        let about = [
            ("channels", image.channels().join(" ")),
            ("sizes", sizes.join(" ")),
            ("order", value_index(image)),
        ];
        let texts = image.texts().iter().map(|(k, v)| (k.as_str(), v.clone()));
        for (key, value) in texts.chain(about) {
            attributes.other.insert(
                text(format!("lumigon-{key}").as_str()),
                AttributeValue::Text(text(value.as_str())),
            );
        }
        Layer::new(
            size,
            attributes,
            Encoding {
                compression: Compression::ZIP16,
                blocks: Blocks::ScanLines,
                line_order: LineOrder::Increasing,
            },
            AnyChannels::sort(list),
        )
    });
    let layers: Layers<_> = layers.collect();
    let mut bytes = Cursor::new(Vec::new());
    let data_window = IntegerBounds::from_dimensions(size);
    Image::from_layers(ImageAttributes::new(data_window), layers)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| TableError::Format {
            name: image.name().to_owned(),
            format: "EXR",
            problem: error.to_string(),
        })?;
    Ok(bytes.into_inner())
}

/// The names, where one comes again with its place behind it: a file has each channel once.
fn unique(names: &[String]) -> Vec<String> {
    let mut unique: Vec<String> = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let mut name = name.clone();
        while unique.contains(&name) || (names[i + 1..].contains(&name) && name != names[i]) {
            name = format!("{name}-{i}");
        }
        unique.push(name);
    }
    unique
}

/// A text in the format's alphabet, Latin-1; what else there is becomes a question mark.
fn text(text: &str) -> Text {
    let latin = |c: char| if u32::from(c) < 256 { c } else { '?' };
    Text::new_or_none(text.chars().map(latin).collect::<String>()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::tests::{bits, example};

    #[test]
    fn names_are_unique_and_first_ones_kept() {
        let names = ["a", "a", "a-1", "b", "a"].map(String::from);
        assert_eq!(unique(&names), ["a", "a-1-1", "a-1", "b", "a-4"]);
    }

    #[test]
    fn round_trip() {
        for sizes in [vec![3, 2], vec![3, 2, 5, 4]] {
            let image = example(&sizes);
            let bytes = encode(&image).unwrap();
            let read = read()
                .no_deep_data()
                .largest_resolution_level()
                .all_channels()
                .all_layers()
                .all_attributes()
                .from_buffered(Cursor::new(bytes))
                .unwrap();
            assert_eq!(read.layer_data.len(), image.values().len() / (6 * 8));
            let mut values = vec![f32::NAN; image.values().len()];
            for (slice, layer) in read.layer_data.iter().enumerate() {
                assert_eq!(layer.size, Vec2(3, 2));
                if sizes.len() == 4 {
                    let name = format!("slice-{}-{}", slice % 5, slice / 5);
                    assert_eq!(layer.attributes.layer_name, Some(name.as_str().into()));
                }
                let frame = &layer.attributes.other[&Text::from("lumigon-frame")];
                assert!(matches!(frame, AttributeValue::Text(_)));
                for (channel, name) in unique(image.channels()).iter().enumerate() {
                    let list = &layer.channel_data.list;
                    let found = list.iter().find(|c| c.name.eq(name.as_str())).unwrap();
                    let FlatSamples::F32(samples) = &found.sample_data else {
                        panic!("{name} isn't f32");
                    };
                    for (texel, value) in samples.iter().enumerate() {
                        values[(slice * 6 + texel) * 8 + channel] = *value;
                    }
                }
            }
            assert_eq!(bits(&values), bits(image.values()));
        }
    }
}
