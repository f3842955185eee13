//! Accessors to numbers.

use gltf::json::{
    self, Accessor,
    accessor::{ComponentType, Type},
    validation::Checked,
};

use super::source::{Source, View};
use crate::scene::error::Fault;

/// Elements of an accessor that has no buffer view and so costs the file nothing.
const MAX_ZEROED: u64 = 1 << 22;

/// Reads accessors within a budget of bytes.
pub(super) struct Reader<'a, 'b> {
    pub(super) root: &'a json::Root,
    pub(super) source: &'b mut Source<'a>,
    /// The most bytes that one accessor may decode to.
    pub(super) limit: u64,
}

/// An accessor whose counts, offsets and types have been checked.
struct Checkpoint<'a> {
    accessor: &'a Accessor,
    place: String,
    component: ComponentType,
    count: usize,
}

impl<'a> Reader<'a, '_> {
    /// An attribute of `N` components as f32; normalised integers become fractions.
    /// Accessors with another number of components are refused, but for `or_fewer`:
    /// then one component less is filled up with 1.
    pub(super) fn floats<const N: usize>(
        &mut self,
        index: usize,
        user: &str,
        or_fewer: bool,
    ) -> Result<Vec<[f32; N]>, Fault> {
        let checkpoint = self.check(index, user)?;
        let (accessor, place) = (checkpoint.accessor, &checkpoint.place);
        let found = components(accessor);
        if found != Some(N) && !(or_fewer && found == Some(N - 1)) {
            let what = format!("{user} needs {N} components, not {}", shown_type(accessor));
            return Err(Fault::new(place, what, "use an accessor of the right type"));
        }
        let found = found.unwrap_or(N);
        let component = checkpoint.component;
        if component == ComponentType::U32 {
            return Err(Fault::new(
                place,
                format!("{user} is of 32-bit integers"),
                "use floats, or 8- or 16-bit integers",
            ));
        }
        let decode = |bytes: &[u8]| {
            std::array::from_fn(|i| {
                if i < found {
                    float(
                        &bytes[i * size(component)..],
                        component,
                        accessor.normalized,
                    )
                } else {
                    1.0
                }
            })
        };
        self.elements(&checkpoint, found * size(component), [0.0; N], decode)
    }

    /// Vertex indices.
    pub(super) fn indices(&mut self, index: usize, user: &str) -> Result<Vec<u32>, Fault> {
        let checkpoint = self.check(index, user)?;
        let component = checkpoint.component;
        let unsigned = matches!(
            component,
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32
        );
        if components(checkpoint.accessor) != Some(1) || !unsigned {
            return Err(Fault::new(
                &checkpoint.place,
                format!("{user} needs unsigned scalars"),
                "use SCALAR of an unsigned integer type",
            ));
        }
        let decode = |bytes: &[u8]| integer(bytes, component);
        self.elements(&checkpoint, size(component), 0, decode)
    }

    fn check(&self, index: usize, user: &str) -> Result<Checkpoint<'a>, Fault> {
        let accessor = self.root.accessors.get(index).ok_or_else(|| {
            let what = format!("there is no accessors[{index}]");
            Fault::new(user, what, "use an index that exists")
        })?;
        let place = format!("accessors[{index}]");
        let Checked::Valid(component) = &accessor.component_type else {
            return Err(Fault::new(
                place + ".componentType",
                "this is not one of glTF's component types",
                "use 5120 to 5123, 5125 or 5126",
            ));
        };
        let count = accessor.count.0;
        // The widest element is 4 floats; `limit` keeps it far from overflow.
        if count > self.limit / 16 {
            let what = format!("{count} elements pass the limit of {} bytes", self.limit);
            return Err(Fault::new(
                place,
                what,
                "make the scene smaller or raise the limit",
            ));
        }
        if accessor.buffer_view.is_none() && count > MAX_ZEROED {
            let what = format!("{count} elements without a buffer view, above {MAX_ZEROED}");
            return Err(Fault::new(place, what, "give the accessor a buffer view"));
        }
        Ok(Checkpoint {
            accessor,
            place,
            component: component.0,
            count: count as usize,
        })
    }

    /// All elements of `size` bytes each, the sparse ones replaced.
    fn elements<T: Copy>(
        &mut self,
        checkpoint: &Checkpoint<'_>,
        size: usize,
        zero: T,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, Fault> {
        let Checkpoint {
            accessor,
            place,
            count,
            ..
        } = checkpoint;
        let mut values = match accessor.buffer_view {
            None => vec![zero; *count],
            Some(view) => {
                let view = self.source.view(view.value(), place)?;
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                let stride = view.stride.unwrap_or(size);
                strided(&view, offset, stride, *count, size, place)?
                    .map(decode_with(&decode))
                    .collect()
            }
        };
        let Some(sparse) = &accessor.sparse else {
            return Ok(values);
        };
        let place = format!("{place}.sparse");
        let replaced = sparse.count.0;
        if replaced > *count as u64 {
            let what = format!("it replaces {replaced} of {count} elements");
            return Err(Fault::new(place, what, "replace no more than there are"));
        }
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err(Fault::new(
                place + ".indices.componentType",
                "this is not an unsigned integer type",
                "use 5121, 5123 or 5125",
            ));
        };
        let replaced = replaced as usize;
        let index_size = self::size(component.0);
        let indices = self
            .source
            .view(sparse.indices.buffer_view.value(), &place)?;
        let offset = sparse.indices.byte_offset.0;
        let indices = strided(&indices, offset, index_size, replaced, index_size, &place)?;
        let new = self
            .source
            .view(sparse.values.buffer_view.value(), &place)?;
        let new = strided(
            &new,
            sparse.values.byte_offset.0,
            size,
            replaced,
            size,
            &place,
        )?;
        for (index, bytes) in indices.zip(new) {
            let index = integer(index, component.0);
            *values.get_mut(index as usize).ok_or_else(|| {
                let what = format!("it replaces element {index} of {count}");
                Fault::new(
                    &place,
                    what,
                    "keep sparse indices below the accessor's count",
                )
            })? = decode(bytes);
        }
        Ok(values)
    }
}

/// Keeps the borrow of `decode` while an iterator uses it.
fn decode_with<T>(decode: &impl Fn(&[u8]) -> T) -> impl Fn(&[u8]) -> T {
    move |bytes| decode(bytes)
}

/// `count` pieces of `size` bytes, `stride` apart, all inside the view.
fn strided<'v>(
    view: &'v View<'_>,
    offset: u64,
    stride: usize,
    count: usize,
    size: usize,
    place: &str,
) -> Result<impl Iterator<Item = &'v [u8]>, Fault> {
    if stride < size {
        return Err(Fault::new(
            place,
            format!("elements of {size} bytes overlap at a stride of {stride}"),
            "give the buffer view a byteStride of at least an element's size",
        ));
    }
    let bytes = view.bytes();
    let end = (count as u64)
        .checked_sub(1)
        .map_or(Some(0), |last| {
            last.checked_mul(stride as u64)?.checked_add(size as u64)
        })
        .and_then(|length| length.checked_add(offset));
    if end.is_none_or(|end| end > bytes.len() as u64) {
        return Err(Fault::new(
            place,
            format!(
                "{count} elements of {size} bytes from {offset} pass its buffer view's {}",
                bytes.len()
            ),
            "keep the accessor inside its buffer view",
        ));
    }
    let start = offset as usize;
    Ok((0..count).map(move |i| &bytes[start + i * stride..][..size]))
}

fn components(accessor: &Accessor) -> Option<usize> {
    match accessor.type_ {
        Checked::Valid(Type::Scalar) => Some(1),
        Checked::Valid(Type::Vec2) => Some(2),
        Checked::Valid(Type::Vec3) => Some(3),
        Checked::Valid(Type::Vec4) => Some(4),
        _ => None,
    }
}

fn shown_type(accessor: &Accessor) -> String {
    match accessor.type_ {
        Checked::Valid(kind) => format!("{kind:?}").to_uppercase(),
        Checked::Invalid => "an unknown type".to_owned(),
    }
}

fn size(component: ComponentType) -> usize {
    match component {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

/// An unsigned integer from the start of `bytes`.
fn integer(bytes: &[u8], component: ComponentType) -> u32 {
    match component {
        ComponentType::U8 => u32::from(bytes[0]),
        ComponentType::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}

/// A number from the start of `bytes`; normalised as in section 3.11 of the glTF 2.0 specification.
fn float(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let (value, largest) = match component {
        ComponentType::F32 => {
            return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        }
        ComponentType::I8 => (f32::from(i8::from_le_bytes([bytes[0]])), 127.0),
        ComponentType::U8 => (f32::from(bytes[0]), 255.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
        ComponentType::U32 => (integer(bytes, component) as f32, u32::MAX as f32),
    };
    if normalized {
        (value / largest).max(-1.0)
    } else {
        value
    }
}
