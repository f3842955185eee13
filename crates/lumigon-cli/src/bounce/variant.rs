//! The ways to virtual lights that are measured.

use lumigon_renderer::{
    BounceCenters, BounceMethod, BounceSettings, BounceVisibility, VirtualLightKind,
};

use crate::bounce_light::{Blocking, SCENE_CENTERS};

/// One way to virtual lights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Variant {
    /// Unique.
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    method: BounceMethod,
    /// Points, not polygons.
    point: bool,
    /// Cube maps look from points in the scene, not from the camera.
    in_scene: bool,
    /// Which light surfaces block.
    pub(super) blocking: Blocking,
    /// Measured over the cube map's size too.
    pub(super) over_sizes: bool,
}

pub(super) const POLYGON_CAMERA: Variant = Variant {
    id: "polygon-camera",
    title: "polygons, camera",
    method: BounceMethod::CubeMap,
    point: false,
    in_scene: false,
    blocking: Blocking::Nothing,
    over_sizes: true,
};

pub(super) const POLYGON_SCENE: Variant = Variant {
    id: "polygon-scene",
    title: "polygons, scene",
    in_scene: true,
    ..POLYGON_CAMERA
};

pub(super) const POINT_CAMERA: Variant = Variant {
    id: "point-camera",
    title: "points, camera",
    point: true,
    over_sizes: false,
    ..POLYGON_CAMERA
};

pub(super) const POINT_SCENE: Variant = Variant {
    id: "point-scene",
    title: "points, scene",
    point: true,
    ..POLYGON_SCENE
};

pub(super) const RSM: Variant = Variant {
    id: "rsm",
    title: "polygons, shadow maps",
    method: BounceMethod::ReflectiveShadowMaps,
    ..POLYGON_CAMERA
};

const POLYGON_CAMERA_TRACED: Variant = Variant {
    id: "polygon-camera-traced",
    title: "polygons, camera, traced",
    blocking: Blocking::Bounces,
    over_sizes: false,
    ..POLYGON_CAMERA
};

pub(super) const POLYGON_SCENE_TRACED: Variant = Variant {
    id: "polygon-scene-traced",
    title: "polygons, scene, traced",
    in_scene: true,
    ..POLYGON_CAMERA_TRACED
};

const POINT_SCENE_TRACED: Variant = Variant {
    id: "point-scene-traced",
    title: "points, scene, traced",
    point: true,
    ..POLYGON_SCENE_TRACED
};

pub(super) const POLYGON_CAMERA_SHADOWED: Variant = Variant {
    id: "polygon-camera-shadowed",
    title: "polygons, camera, all traced",
    blocking: Blocking::All,
    ..POLYGON_CAMERA_TRACED
};

pub(super) const POLYGON_SCENE_SHADOWED: Variant = Variant {
    id: "polygon-scene-shadowed",
    title: "polygons, scene, all traced",
    in_scene: true,
    over_sizes: true,
    ..POLYGON_CAMERA_SHADOWED
};

pub(super) const RSM_SHADOWED: Variant = Variant {
    id: "rsm-shadowed",
    title: "polygons, shadow maps, all traced",
    method: BounceMethod::ReflectiveShadowMaps,
    ..POLYGON_CAMERA_SHADOWED
};

/// All whose errors are measured.
pub(super) const VARIANTS: [Variant; 10] = [
    POLYGON_CAMERA,
    POLYGON_SCENE,
    POINT_SCENE,
    RSM,
    POLYGON_CAMERA_TRACED,
    POLYGON_SCENE_TRACED,
    POINT_SCENE_TRACED,
    POLYGON_CAMERA_SHADOWED,
    POLYGON_SCENE_SHADOWED,
    RSM_SHADOWED,
];

impl Variant {
    /// Whether rays are traced.
    pub(super) fn traces(&self) -> bool {
        self.blocking != Blocking::Nothing
    }

    pub(super) fn in_scene(&self) -> bool {
        self.in_scene
    }

    pub(super) fn settings(&self, virtual_lights: u32, face_size: u32) -> BounceSettings {
        BounceSettings {
            method: self.method,
            centers: match self.in_scene {
                true => BounceCenters::Scene(SCENE_CENTERS),
                false => BounceCenters::Camera,
            },
            face_size,
            virtual_lights,
            kind: match self.point {
                true => VirtualLightKind::Point {
                    least_distance: None,
                },
                false => VirtualLightKind::Polygon,
            },
            visibility: match self.traces() {
                true => BounceVisibility::Traced,
                false => BounceVisibility::None,
            },
            shadows: self.blocking == Blocking::All,
            ..BounceSettings::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_variant_is_its_own() {
        let ids: BTreeSet<_> = VARIANTS.iter().map(|v| v.id).collect();
        let settings: BTreeSet<_> = VARIANTS
            .iter()
            .map(|v| format!("{:?}", v.settings(9, 9)))
            .collect();
        assert_eq!(
            (ids.len(), settings.len()),
            (VARIANTS.len(), VARIANTS.len())
        );
    }
}
