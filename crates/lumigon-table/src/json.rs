use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::description::value_index;
use crate::error::TableError;
use crate::image::TableImage;

/// The whole table, readable.
#[derive(Serialize, Deserialize)]
struct JsonTable {
    name: String,
    sizes: Vec<usize>,
    channels: Vec<String>,
    index: String,
    about: BTreeMap<String, String>,
    values: Vec<f32>,
}

pub(crate) fn encode(image: &TableImage) -> Result<Vec<u8>, TableError> {
    let table = JsonTable {
        name: image.name().to_owned(),
        sizes: image.sizes().to_vec(),
        channels: image.channels().to_vec(),
        index: value_index(image),
        about: image.texts().iter().cloned().collect(),
        values: Vec::new(),
    };
    // Pretty but for the numbers, of which one a line would be tens of thousands of lines.
    let mut text = pretty(image, &table)?;
    let numbers: Vec<String> = image
        .values()
        .chunks(image.channels().len())
        .map(|texel| serde_json::to_string(texel).map(|t| t[1..t.len() - 1].to_owned()))
        .collect::<Result<_, _>>()
        .map_err(|error| failed(image, &error))?;
    let open = text.len() - b"]\n}\n".len();
    text.truncate(open);
    text.extend(format!("\n    {}\n  ]\n}}\n", numbers.join(",\n    ")).into_bytes());
    Ok(text)
}

/// Indented, with a line's end at the end.
pub(crate) fn pretty(image: &TableImage, value: &impl Serialize) -> Result<Vec<u8>, TableError> {
    let mut text = serde_json::to_vec_pretty(value).map_err(|error| failed(image, &error))?;
    text.push(b'\n');
    Ok(text)
}

fn failed(image: &TableImage, error: &serde_json::Error) -> TableError {
    TableError::Format {
        name: image.name().to_owned(),
        format: "JSON",
        problem: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::tests::{bits, example};

    #[test]
    fn round_trip() {
        for sizes in [vec![3, 2], vec![3, 2, 5, 4]] {
            let image = example(&sizes);
            let text = encode(&image).unwrap();
            let table: JsonTable = serde_json::from_slice(&text).unwrap();
            assert_eq!(bits(&table.values), bits(image.values()));
            assert_eq!((table.sizes, table.name.as_str()), (sizes, "example-3"));
            assert_eq!(table.channels, image.channels());
            assert_eq!(table.about["command"], "lumigon fit \"ggx\" */ \\");
        }
    }
}
