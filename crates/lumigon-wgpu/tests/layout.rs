//! The host's records are the shaders' structs, number for number.

use std::mem::{offset_of, size_of};

use lumigon_wgpu::{
    CLUSTER_LIGHTS, ImageRecord, LightFieldRecord, LightRecord, MODULES, PolygonRecord,
};

struct Structs(naga::Module);

impl Structs {
    fn library() -> Self {
        let text = lumigon_shaders::library_with(MODULES).unwrap();
        let parsed = naga::front::wgsl::parse_str(&text);
        Self(parsed.unwrap_or_else(|fault| panic!("{}", fault.emit_to_string(&text))))
    }

    /// Size, and each member's name and offset.
    fn of(&self, name: &str) -> (usize, Vec<(&str, usize)>) {
        let found = self.0.types.iter().find_map(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { members, span } if ty.name.as_deref() == Some(name) => {
                let member = |m: &naga::StructMember| m.offset as usize;
                let named = members
                    .iter()
                    .map(|m| (m.name.as_deref().unwrap_or_default(), member(m)))
                    .collect();
                Some((*span as usize, named))
            }
            _ => None,
        });
        found.unwrap_or_else(|| panic!("the shaders have no struct {name}"))
    }
}

macro_rules! layout {
    ($record:ty: $($member:ident),*) => {
        (size_of::<$record>(), vec![$((stringify!($member), offset_of!($record, $member))),*])
    };
}

#[test]
fn records_are_laid_out_as_the_shaders_have_them() {
    let shaders = Structs::library();
    assert_eq!(
        shaders.of("PolygonLight"),
        layout!(PolygonRecord: center, inverse_radius, normal, doubled_area, centroid,
            plane_tolerance, plane_axis, both_sides)
    );
    assert_eq!(
        shaders.of("Light"),
        layout!(LightRecord: polygon, radiance, first_record, end_record, image)
    );
    assert_eq!(
        shaders.of("ShownImage"),
        layout!(ImageRecord: corner, first_texel, edge_u, has_gaussian_levels, edge_v, size,
            greatest, gaussian)
    );
    assert_eq!(
        shaders.of("LightField"),
        layout!(LightFieldRecord: light_to_field, first_texel, resolution, phi)
    );
    // The list starts where its first record is aligned.
    assert_eq!(shaders.of("Lights").1, [("count", 0), ("list", 16)]);
}

#[test]
fn a_clusters_lights_fit_a_mask() {
    assert_eq!(CLUSTER_LIGHTS, u32::BITS as usize);
}

/// WGSL's list of bindings, as the bind group's documentation has it.
#[test]
fn bindings_are_where_the_layout_has_them() {
    let shaders = Structs::library();
    let mut bindings: Vec<_> = shaders
        .0
        .global_variables
        .iter()
        .filter_map(|(_, variable)| {
            let at = variable.binding?;
            Some((at.group, at.binding, variable.name.clone()?))
        })
        .collect();
    bindings.sort();
    let names = [
        "lights",
        "light_vertices",
        "ltc_tables",
        "anisotropic_ltc_table",
        "distance_fields",
        "light_fields",
        "light_images",
        "light_image_texels",
    ];
    let expected: Vec<_> = (0..)
        .zip(names)
        .map(|(i, n)| (0, i, n.to_owned()))
        .collect();
    assert_eq!(bindings, expected);
}
