//! Bounce light on the command line.

use clap::{Args, ValueEnum};
use lumigon_renderer::{
    BounceCenters, BounceMethod, BounceSettings, BounceVisibility, MAXIMUM_BOUNCES,
    MAXIMUM_FACE_SIZE, MAXIMUM_VIRTUAL_LIGHTS, ReferenceSettings, VirtualLightKind,
};
use serde::Serialize;

use crate::Failure;

/// Cube maps of `--bounce-from scene` where no number is given.
pub(crate) const SCENE_CENTERS: u32 = 4;

/// Most cube maps that a command line asks for.
const MOST_CENTERS: usize = 1024;

/// What computes bounce light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Virtual lights where cube maps see lit surfaces, all lights at once
    #[default]
    CubeMap,
    /// Virtual lights from reflective shadow maps: where each light sees surfaces
    Rsm,
    /// Path traced, with noise, always on the CPU
    Path,
}

/// What virtual lights are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// Polygons on the surfaces, by the exact integral
    #[default]
    Polygon,
    /// Points whose light stops growing at a distance: the usual practice
    Point,
}

/// What blocks light on its way from one surface to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Visibility {
    /// Nothing: light leaks
    #[default]
    None,
    /// Surfaces: one ray to each virtual light
    Traced,
}

/// What surfaces block in a path-traced single bounce: errors of sampling and of visibility are told
/// apart by which of them a method is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Blocking {
    /// Nothing: what virtual lights without visibility tend to.
    Nothing,
    /// What surfaces reflect, not what lights emit: what traced virtual lights tend to.
    Bounces,
    /// All light: the truth.
    All,
}

impl Blocking {
    pub(crate) const ALL: [Self; 3] = [Self::Nothing, Self::Bounces, Self::All];

    /// Its name in file names.
    pub(crate) fn id(self) -> &'static str {
        match self {
            Self::Nothing => "bounce-unblocked",
            Self::Bounces => "bounce-blocked",
            Self::All => "bounce-shadowed",
        }
    }

    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Nothing => "Bounce light that nothing blocks",
            Self::Bounces => "Bounce light that surfaces block, not the lights' own",
            Self::All => "Bounce light, all of it shadowed",
        }
    }

    /// The light of exactly one reflection before the surface that is seen.
    pub(crate) fn single_bounce(self, settings: ReferenceSettings) -> ReferenceSettings {
        ReferenceSettings {
            bounces: 2,
            shadows: self == Self::All,
            direct: false,
            bounce_shadows: self != Self::Nothing,
            ..settings
        }
    }
}

/// Light that surfaces reflect onto others.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Bounce light")]
pub(crate) struct BounceLight {
    /// How often light may be reflected before it reaches the surface that is seen; 0 is direct
    /// light alone [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=i64::from(MAXIMUM_BOUNCES)))]
    bounce: Option<u32>,
    /// What computes it [default: cube-map]
    #[arg(long, value_enum, value_name = "METHOD")]
    bounce_method: Option<Method>,
    /// Virtual lights at most [default: 1024]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAXIMUM_VIRTUAL_LIGHTS)))]
    virtual_lights: Option<u32>,
    /// What virtual lights are [default: polygon]
    #[arg(long = "virtual", value_enum, value_name = "KIND")]
    virtual_kind: Option<Kind>,
    /// Distance below which --virtual point does not grow brighter, in scene units [default: a
    /// twentieth of the scene's diagonal]
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true, value_parser = clamp)]
    virtual_clamp: Option<f32>,
    /// Texels across each face of a cube map [default: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAXIMUM_FACE_SIZE)))]
    cube_size: Option<u32>,
    /// Where cube maps look from: the camera, points chosen in the scene (scene:4 is four of them),
    /// or points X,Y,Z;X,Y,Z... [default: scene:4]
    #[arg(long, value_name = "camera|scene[:N]|X,Y,Z...", allow_hyphen_values = true,
        value_parser = centers)]
    bounce_from: Option<BounceCenters>,
    /// What blocks light between surfaces [default: none]
    #[arg(long, value_enum, value_name = "WHAT")]
    bounce_visibility: Option<Visibility>,
    /// Surfaces block the lights' own light before it is reflected, though direct light has no
    /// shadows
    #[arg(long)]
    bounce_shadows: bool,
    /// Do not merge texels of one plane into polygons with the surfaces' outlines
    #[arg(long)]
    no_merge: bool,
    /// Do not bring texels down to K virtual lights: each is one, or what merging leaves
    #[arg(long)]
    no_cluster: bool,
    /// Leave direct light out
    #[arg(long)]
    bounce_only: bool,
}

/// What the command line makes of bounce light.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Bounce {
    /// Direct light alone.
    None,
    /// Virtual lights, from cube maps or reflective shadow maps.
    Virtual(BounceSettings),
    /// The path tracer's.
    Path {
        bounces: u32,
        /// Surfaces block the lights' own light.
        shadows: bool,
        /// Surfaces block what surfaces reflect.
        bounce_shadows: bool,
    },
}

impl BounceLight {
    /// Whether direct light is wanted.
    pub(crate) fn direct(&self) -> bool {
        !self.bounce_only
    }

    /// What to compute, or what is wrong with the combination; `subcommand` has the flags.
    pub(crate) fn resolve(&self, subcommand: &str) -> Result<Bounce, Failure> {
        match self.contradiction() {
            Some(message) => return Err(Failure::usage(subcommand, &message)),
            None if self.bounces() == 0 => return Ok(Bounce::None),
            None => {}
        }
        let method = match self.bounce_method.unwrap_or_default() {
            Method::CubeMap => BounceMethod::CubeMap,
            Method::Rsm => BounceMethod::ReflectiveShadowMaps,
            Method::Path => {
                return Ok(Bounce::Path {
                    bounces: self.bounces(),
                    shadows: self.bounce_shadows,
                    bounce_shadows: self.visibility() == Visibility::Traced,
                });
            }
        };
        Ok(Bounce::Virtual(BounceSettings {
            method,
            ..self.settings()
        }))
    }

    /// The settings of virtual lights, of a cube map and of one bounce where nothing else is asked for.
    pub(crate) fn settings(&self) -> BounceSettings {
        let default = BounceSettings::default();
        BounceSettings {
            bounces: self.bounces().max(1),
            method: default.method,
            centers: self.bounce_from.clone().unwrap_or_default(),
            face_size: self.cube_size.unwrap_or(default.face_size),
            virtual_lights: self.virtual_lights.unwrap_or(default.virtual_lights),
            kind: match self.virtual_kind.unwrap_or_default() {
                Kind::Polygon => VirtualLightKind::Polygon,
                Kind::Point => VirtualLightKind::Point {
                    least_distance: self.virtual_clamp,
                },
            },
            merges: !self.no_merge,
            clusters: !self.no_cluster,
            visibility: match self.visibility() {
                Visibility::None => BounceVisibility::None,
                Visibility::Traced => BounceVisibility::Traced,
            },
            shadows: self.bounce_shadows,
        }
    }

    fn bounces(&self) -> u32 {
        self.bounce.unwrap_or(0)
    }

    fn visibility(&self) -> Visibility {
        self.bounce_visibility.unwrap_or_default()
    }

    fn contradiction(&self) -> Option<String> {
        let of_virtual_lights = [
            ("--virtual-lights", self.virtual_lights.is_some()),
            ("--virtual", self.virtual_kind.is_some()),
            ("--virtual-clamp", self.virtual_clamp.is_some()),
            ("--cube-size", self.cube_size.is_some()),
            ("--bounce-from", self.bounce_from.is_some()),
            ("--no-merge", self.no_merge),
            ("--no-cluster", self.no_cluster),
        ];
        let of_all = [
            ("--bounce-method", self.bounce_method.is_some()),
            ("--bounce-visibility", self.bounce_visibility.is_some()),
            ("--bounce-shadows", self.bounce_shadows),
            ("--bounce-only", self.bounce_only),
        ];
        if self.bounces() == 0 {
            let flag = first_given(of_all.into_iter().chain(of_virtual_lights))?;
            return Some(format!("{flag} is of use with --bounce 1 or more only"));
        }
        let method = self.bounce_method.unwrap_or_default();
        if method == Method::Path
            && let Some(flag) = first_given(of_virtual_lights)
        {
            return Some(format!("{flag} is of no use with --bounce-method path"));
        }
        if method == Method::Rsm && self.bounce_from.is_some() {
            let message =
                "--bounce-from places cube maps: --bounce-method rsm looks from the lights";
            return Some(message.to_owned());
        }
        if method == Method::Rsm && self.bounces() > 1 {
            return Some("--bounce-method rsm knows one bounce: leave --bounce 1".to_owned());
        }
        if self.virtual_clamp.is_some() && self.virtual_kind != Some(Kind::Point) {
            return Some("--virtual-clamp is of use with --virtual point only".to_owned());
        }
        if self.no_cluster && self.virtual_lights.is_some() {
            return Some("--virtual-lights is of no use with --no-cluster".to_owned());
        }
        None
    }
}

fn first_given(flags: impl IntoIterator<Item = (&'static str, bool)>) -> Option<&'static str> {
    let mut given = flags.into_iter().filter(|(_, given)| *given);
    given.next().map(|(flag, _)| flag)
}

/// A distance of [`VirtualLightKind::Point`].
pub(crate) fn clamp(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(distance) if distance > 0.0 && f32::is_finite(distance) => Ok(distance),
        _ => Err("give a distance, more than 0".to_owned()),
    }
}

/// Places of cube maps.
pub(crate) fn centers(text: &str) -> Result<BounceCenters, String> {
    match text {
        "camera" => return Ok(BounceCenters::Camera),
        "scene" => return Ok(BounceCenters::Scene(SCENE_CENTERS)),
        _ => {}
    }
    if let Some(count) = text.strip_prefix("scene:") {
        return match count.parse() {
            Ok(count) if (1..=MOST_CENTERS as u32).contains(&count) => {
                Ok(BounceCenters::Scene(count))
            }
            _ => Err(format!("give scene:N with N from 1 to {MOST_CENTERS}")),
        };
    }
    let points: Vec<[f32; 3]> = text
        .split(';')
        .map(|point| {
            let mut numbers = point.split(',').map(|number| number.trim().parse::<f32>());
            let mut next = || numbers.next()?.ok().filter(|number| number.is_finite());
            let point = [next()?, next()?, next()?];
            numbers.next().is_none().then_some(point)
        })
        .collect::<Option<_>>()
        .ok_or("give camera, scene, scene:N, or points as X,Y,Z;X,Y,Z, such as 0,1.5,-2;1,1,1")?;
    if points.len() > MOST_CENTERS {
        return Err(format!("give at most {MOST_CENTERS} points"));
    }
    Ok(BounceCenters::Points(points))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centers_are_read() {
        assert_eq!(centers("camera"), Ok(BounceCenters::Camera));
        assert_eq!(centers("scene"), Ok(BounceCenters::Scene(SCENE_CENTERS)));
        assert_eq!(centers("scene:9"), Ok(BounceCenters::Scene(9)));
        let points = vec![[-1.0, 2.5, 3e3], [0.0, 0.0, -0.5]];
        assert_eq!(
            centers("-1,2.5,3e3; 0,0,-.5"),
            Ok(BounceCenters::Points(points))
        );
        for bad in [
            "",
            "Camera",
            "scene:",
            "scene:0",
            "scene:-1",
            "scene:1025",
            "scene:x",
            "1,2",
            "1,2,3,4",
            "1,2,nan",
            "1,2,inf",
            "1e39,0,0",
            "1,2,3;",
            ";",
            "--bounce",
            "1 2 3",
        ] {
            assert!(centers(bad).is_err(), "{bad}");
        }
        assert!(centers(&["0,0,0"; 1025].join(";")).is_err());
    }

    #[test]
    fn clamps_are_distances() {
        assert_eq!(clamp("0.25"), Ok(0.25));
        for bad in ["0", "-1", "nan", "inf", "x", "1e39"] {
            assert!(clamp(bad).is_err(), "{bad}");
        }
    }
}
