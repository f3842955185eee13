//! One field for all lights of a shape.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use super::field::DistanceField;
use super::reflect::PlacedDistanceField;
use super::settings::{DistanceFieldError, DistanceFieldSettings};
use crate::polygon::PolygonLight;
use crate::real::Scalar;

/// In radii: vertices no farther apart count as the same. Texels are a hundred times as large.
const TOLERANCE: f64 = 1e-4;

/// Vertices that a loop may be tried to start at.
const MOST_STARTS: usize = 64;

/// Which field a light has, and how it lies there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPlacement<S> {
    /// Index into the fields.
    pub field: usize,
    /// [a, b, c, d] take the point (x, y) of the light's plane, in radii along its axes, to the
    /// field's (a x - b y + c, b x + a y + d).
    pub light_to_field: [S; 4],
}

/// The distance fields of many lights: lights of one shape, wherever they are, however they are
/// turned and whatever their size, share one.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceFields<S> {
    fields: Vec<DistanceField>,
    placements: Vec<FieldPlacement<S>>,
}

impl<S: Scalar + Send + Sync> DistanceFields<S> {
    /// Bakes each shape among the lights once; all fields together may have `budget` bytes.
    ///
    /// With the feature `parallel` on all threads.
    ///
    /// # Errors
    /// Where the shapes need more than the budget.
    pub fn new<'a>(
        lights: impl IntoIterator<Item = &'a PolygonLight<S>>,
        settings: DistanceFieldSettings,
        budget: u64,
    ) -> Result<Self, DistanceFieldError>
    where
        S: 'a,
    {
        let (fields, _) = Self::with_baked(lights, settings, budget, |_| None)?;
        Ok(fields)
    }

    /// The same, where some shapes may have been baked before: `baked` gives the field of a light of
    /// [the same outline](PolygonLight::has_outline_of), baked with the same settings. Also returns
    /// which light each field is of.
    ///
    /// # Errors
    /// Where the shapes need more than the budget.
    pub fn with_baked<'a>(
        lights: impl IntoIterator<Item = &'a PolygonLight<S>>,
        settings: DistanceFieldSettings,
        budget: u64,
        baked: impl Fn(&PolygonLight<S>) -> Option<DistanceField> + Sync,
    ) -> Result<(Self, Vec<usize>), DistanceFieldError>
    where
        S: 'a,
    {
        let lights: Vec<_> = lights.into_iter().collect();
        let (shapes, placements) = field_shapes(&lights, settings.phi().into());
        check_budget(shapes.len(), settings, budget)?;
        let bake = |&shape: &usize| {
            let light = lights[shape];
            baked(light).unwrap_or_else(|| DistanceField::new(light, settings))
        };
        #[cfg(feature = "parallel")]
        let fields = {
            use rayon::prelude::*;
            shapes.par_iter().map(bake).collect()
        };
        #[cfg(not(feature = "parallel"))]
        let fields = shapes.iter().map(bake).collect();
        Ok((Self { fields, placements }, shapes))
    }
}

impl<S: Scalar> DistanceFields<S> {
    /// One for each shape.
    pub fn fields(&self) -> &[DistanceField] {
        &self.fields
    }

    /// One for each light, in their order.
    pub fn placements(&self) -> &[FieldPlacement<S>] {
        &self.placements
    }

    /// The field of each light, in their order.
    pub fn iter(&self) -> impl Iterator<Item = PlacedDistanceField<'_, S>> {
        self.placements.iter().map(|placement| PlacedDistanceField {
            field: &self.fields[placement.field],
            light_to_field: placement.light_to_field,
        })
    }
}

/// Whether so many fields fit a budget in bytes.
///
/// # Errors
/// Where they do not.
pub fn check_budget(
    shapes: usize,
    settings: DistanceFieldSettings,
    budget: u64,
) -> Result<(), DistanceFieldError> {
    let one = (settings.texel_count() * size_of::<f32>()) as u64;
    let needed = one.saturating_mul(shapes as u64);
    if needed <= budget {
        return Ok(());
    }
    Err(DistanceFieldError::OverBudget {
        shapes,
        resolution: settings.resolution(),
        needed,
        budget,
    })
}

/// The lights whose fields serve all of them, and where each light lies in its field.
///
/// Outlines are equal up to position, rotation and size when their vertices are, in order; mirrored
/// ones differ. What goes unnoticed (loops in another order) costs a field more, and nothing else.
pub fn field_shapes<S: Scalar>(
    lights: &[&PolygonLight<S>],
    phi: f64,
) -> (Vec<usize>, Vec<FieldPlacement<S>>) {
    let mut shapes = Vec::new();
    let mut known: BTreeMap<Key, Vec<usize>> = BTreeMap::new();
    let mut placements = Vec::with_capacity(lights.len());
    for (i, light) in lights.iter().enumerate() {
        let key = Key::new(light);
        let found = key.neighbors().into_iter().find_map(|key| {
            let candidates = known.get(&key)?;
            candidates.iter().find_map(|&field| {
                let shape: usize = shapes[field];
                similarity(light, lights[shape]).map(|similarity| (field, similarity))
            })
        });
        let (field, similarity) = found.unwrap_or_else(|| {
            known.entry(key).or_default().push(shapes.len());
            shapes.push(i);
            (shapes.len() - 1, [1.0, 0.0, 0.0, 0.0])
        });
        placements.push(FieldPlacement {
            field,
            light_to_field: similarity.map(|x| S::from_f64(x / phi)),
        });
    }
    (shapes, placements)
}

/// What similar outlines share: their counts, and the area over the squared perimeter, in steps.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    loop_ends: Vec<usize>,
    roundness: i64,
}

impl Key {
    fn new<S: Scalar>(light: &PolygonLight<S>) -> Self {
        let mut perimeter = 0.0;
        for range in light.loop_ranges() {
            let mut start = vertex(light, range.end - 1);
            for i in range {
                let end = vertex(light, i);
                perimeter += length([end[0] - start[0], end[1] - start[1]]);
                start = end;
            }
        }
        let roundness = light.doubled_area.to_f64() / (perimeter * perimeter);
        Self {
            loop_ends: light.loop_ends.clone(),
            roundness: (roundness * 1e5) as i64,
        }
    }

    /// Itself, and those next to it: rounding may step over.
    fn neighbors(&self) -> [Self; 3] {
        [0, -1, 1].map(|step| Self {
            loop_ends: self.loop_ends.clone(),
            roundness: self.roundness + step,
        })
    }
}

fn vertex<S: Scalar>(light: &PolygonLight<S>, i: usize) -> [f64; 2] {
    light.plane_offsets[i].map(Scalar::to_f64)
}

fn length([x, y]: [f64; 2]) -> f64 {
    libm::sqrt(x * x + y * y)
}

/// [a, b, c, d] that take each vertex (x, y) of `light` to (a x - b y + c, b x + a y + d), a vertex of
/// `shape`; none where nothing does.
fn similarity<S: Scalar>(light: &PolygonLight<S>, shape: &PolygonLight<S>) -> Option<[f64; 4]> {
    let starts = match light.loop_count() {
        1 => light.vertex_count().min(MOST_STARTS),
        _ => 1,
    };
    (0..starts).find_map(|start| similarity_from(light, shape, start))
}

/// The same, the first vertex of `light` being that of `shape` at `start`.
fn similarity_from<S: Scalar>(
    light: &PolygonLight<S>,
    shape: &PolygonLight<S>,
    start: usize,
) -> Option<[f64; 4]> {
    let count = light.vertex_count();
    let turned = |i: usize| {
        vertex(
            shape,
            if i + start < count {
                i + start
            } else {
                i + start - count
            },
        )
    };
    // Complex least squares, z q + o = p, about the means.
    let (mut p_mean, mut q_mean) = ([0.0; 2], [0.0; 2]);
    for i in 0..count {
        let (p, q) = (turned(i), vertex(light, i));
        for k in 0..2 {
            p_mean[k] += p[k] / count as f64;
            q_mean[k] += q[k] / count as f64;
        }
    }
    let (mut a, mut b, mut squares) = (0.0, 0.0, 0.0);
    for i in 0..count {
        let (p, q) = (turned(i), vertex(light, i));
        let p = [p[0] - p_mean[0], p[1] - p_mean[1]];
        let q = [q[0] - q_mean[0], q[1] - q_mean[1]];
        a += q[0] * p[0] + q[1] * p[1];
        b += q[0] * p[1] - q[1] * p[0];
        squares += q[0] * q[0] + q[1] * q[1];
    }
    let (a, b) = (a / squares, b / squares);
    let c = p_mean[0] - (a * q_mean[0] - b * q_mean[1]);
    let d = p_mean[1] - (b * q_mean[0] + a * q_mean[1]);
    let fits = (0..count).all(|i| {
        let (p, [x, y]) = (turned(i), vertex(light, i));
        length([a * x - b * y + c - p[0], b * x + a * y + d - p[1]]) <= TOLERANCE
    });
    fits.then_some([a, b, c, d])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::Sides;
    use alloc::vec;

    /// An outline in the plane z = `height` turned by `angle`, scaled, moved, from vertex `start` on.
    fn placed(outline: &[[f64; 2]], angle: f64, size: f64, start: usize) -> PolygonLight<f32> {
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        let mut loops = vec![
            outline
                .iter()
                .map(|[x, y]| [size * (c * x - s * y) + 3.0, 40.0, -size * (s * x + c * y)])
                .collect::<Vec<_>>(),
        ];
        loops[0].rotate_left(start);
        PolygonLight::new(&loops, Sides::Both)
            .unwrap()
            .cast()
            .unwrap()
    }

    const ARROW: [[f64; 2]; 5] = [[0.0, 0.0], [2.0, 1.0], [0.5, 1.0], [0.5, 3.0], [0.0, 3.0]];
    const QUAD: [[f64; 2]; 5] = [[0.0, 0.0], [2.0, 0.0], [2.5, 1.0], [2.0, 2.0], [0.0, 2.0]];

    #[test]
    fn lights_of_one_shape_share_a_field() {
        let mut mirrored = ARROW.map(|[x, y]| [-x, y]);
        mirrored.reverse();
        let lights = [
            placed(&ARROW, 0.0, 1.0, 0),
            placed(&QUAD, 0.3, 1.0, 0),
            placed(&ARROW, 1.0, 7.0, 0),
            placed(&ARROW, 4.0, 0.01, 3),
            placed(&mirrored, 0.0, 1.0, 0),
            placed(&QUAD, 2.0, 2.0, 1),
        ];
        let lights: Vec<_> = lights.iter().collect();
        let (shapes, placements) = field_shapes(&lights, 2.0);
        assert_eq!(shapes, [0, 1, 4]);
        let fields: Vec<_> = placements.iter().map(|p| p.field).collect();
        assert_eq!(fields, [0, 1, 0, 0, 2, 1]);
        // Every placement takes the light's vertices to the shape's, in the field's units.
        for (light, placement) in lights.iter().zip(&placements) {
            let [a, b, c, d] = placement.light_to_field.map(f64::from);
            let shape = lights[shapes[placement.field]];
            for i in 0..5 {
                let [x, y] = vertex(light, i);
                let (x, y) = (2.0 * (a * x - b * y + c), 2.0 * (b * x + a * y + d));
                let nearest = (0..5)
                    .map(|i| vertex(shape, i))
                    .map(|p| length([p[0] - x, p[1] - y]))
                    .fold(f64::INFINITY, f64::min);
                assert!(nearest < TOLERANCE, "{nearest}");
            }
        }
    }

    #[test]
    fn more_than_the_budget_is_refused() {
        let settings = DistanceFieldSettings::new(64, 2.0, false).unwrap();
        let lights = [placed(&ARROW, 0.0, 1.0, 0), placed(&QUAD, 0.0, 1.0, 0)];
        let one = 4 * settings.texel_count() as u64;
        assert!(DistanceFields::new(&lights, settings, 2 * one).is_ok());
        let fault = DistanceFields::new(&lights, settings, 2 * one - 1).unwrap_err();
        assert!(fault.to_string().contains("2 shapes"), "{fault}");
        let none: [PolygonLight<f32>; 0] = [];
        assert!(
            DistanceFields::new(&none, settings, 0)
                .unwrap()
                .fields()
                .is_empty()
        );
    }
}
