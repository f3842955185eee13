//! `KHR_lights_punctual`.

use glam::{DAffine3, DVec3, Vec3};
use gltf::json::{
    self,
    extensions::scene::khr_lights_punctual::{KhrLightsPunctual, Type},
    validation::Checked,
};

use super::value::check_finite;
use crate::scene::{PunctualKind, PunctualLight, error::Fault};

/// The light of one node.
pub(super) fn convert(
    root: &json::Root,
    reference: &KhrLightsPunctual,
    node_name: &str,
    world_from_local: &DAffine3,
    user: &str,
) -> Result<PunctualLight, Fault> {
    let index = reference.light.value();
    let lights = root
        .extensions
        .as_ref()
        .and_then(|e| e.khr_lights_punctual.as_ref());
    let light = lights
        .and_then(|list| list.lights.get(index))
        .ok_or_else(|| {
            let what = format!("there is no KHR_lights_punctual light {index}");
            Fault::new(user, what, "use an index that exists")
        })?;
    let place = format!("extensions.KHR_lights_punctual.lights[{index}]");
    let kind = match light.type_ {
        Checked::Valid(Type::Directional) => PunctualKind::Directional,
        Checked::Valid(Type::Point) => PunctualKind::Point,
        Checked::Valid(Type::Spot) => {
            let spot = light.spot.clone().ok_or_else(|| {
                Fault::new(
                    &place,
                    "this spot light has no spot property",
                    "give it one",
                )
            })?;
            let (inner, outer) = (spot.inner_cone_angle, spot.outer_cone_angle);
            if !(0.0 <= inner && inner <= outer && outer <= std::f32::consts::FRAC_PI_2 + 1e-4) {
                return Err(Fault::new(
                    place + ".spot",
                    format!("inner cone {inner} and outer cone {outer} are not in order"),
                    "keep 0 ≤ inner ≤ outer ≤ π/2",
                ));
            }
            PunctualKind::Spot {
                inner_cone_angle: inner,
                outer_cone_angle: outer,
            }
        }
        Checked::Invalid => {
            return Err(Fault::new(
                place + ".type",
                "this is not a type of punctual light",
                "use directional, point or spot",
            ));
        }
    };
    let color = Vec3::from(light.color) * light.intensity;
    check_finite(&color.to_array(), || place.clone())?;
    if light
        .range
        .is_some_and(|range| !(range > 0.0 && range.is_finite()))
    {
        return Err(Fault::new(
            place + ".range",
            "this is not positive",
            "use a positive range",
        ));
    }
    let direction = world_from_local.transform_vector3(DVec3::NEG_Z);
    Ok(PunctualLight {
        name: light.name.as_deref().unwrap_or(node_name).to_owned(),
        kind,
        position: world_from_local.translation.as_vec3(),
        direction: direction.normalize_or(DVec3::NEG_Z).as_vec3(),
        color: color.max(Vec3::ZERO),
        range: light.range,
    })
}
