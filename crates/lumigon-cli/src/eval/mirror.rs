//! Answers by the mirrored view: whether it meets the light, and how far from it.

use lumigon::{
    DistanceField, DistanceFieldSettings, DistanceFieldSmoothness, InclusionRule,
    PlacedDistanceField, PolygonLight, Scalar, Vec3, reflected_distance, reflected_image,
    reflected_inclusion, schlick,
};

use super::answer::{Answer, Number, Shown};
use super::question::{Question, QuestionError};

/// How much wider a reflected distance's square gets for each unit of the ray's length, over alpha.
const FIELD_SPREAD: f64 = 4.0;

/// The value of `reflected_inclusion`.
pub(super) fn inclusion<S: Scalar + Into<Number>>(
    question: &Question,
    light: &PolygonLight<S>,
    shown: &Shown<S>,
    point: Vec3<S>,
) -> Result<Answer, QuestionError> {
    let [normal, view] = [question.normal()?, question.view()?].map(vector);
    let rule = InclusionRule::CrossingNumber;
    let value = reflected_inclusion(light, point, normal, view, rule);
    Ok(answer(light, shown, [point, normal, view], value, 0.0))
}

/// The value of `reflected_distance`.
pub(super) fn distance<S: Scalar + Into<Number>>(
    question: &Question,
    light: &PolygonLight<S>,
    shown: &Shown<S>,
    point: Vec3<S>,
) -> Result<Answer, QuestionError> {
    let [normal, view] = [question.normal()?, question.view()?].map(vector);
    let alpha = question.alpha()?;
    let default = DistanceFieldSettings::default();
    let settings = DistanceFieldSettings::new(
        question.resolution.unwrap_or(default.resolution()),
        question.phi.unwrap_or(default.phi()),
        false,
    )?;
    let smoothness = match question.smoothness {
        Some(smoothness) => DistanceFieldSmoothness::fixed(smoothness)?,
        None => DistanceFieldSmoothness::default(),
    };
    let field = DistanceField::new(light, settings);
    let placed = PlacedDistanceField::own(&field);
    let width = S::from_f64(alpha);
    let value = reflected_distance(light, placed, point, normal, view, width, smoothness);
    let spread = FIELD_SPREAD * alpha;
    Ok(answer(light, shown, [point, normal, view], value, spread))
}

/// With the mirror's own Schlick weight, and the colour that the light shows there.
fn answer<S: Scalar + Into<Number>>(
    light: &PolygonLight<S>,
    shown: &Shown<S>,
    [point, normal, view]: [Vec3<S>; 3],
    value: S,
    spread: f64,
) -> Answer {
    let spread = S::from_f64(spread);
    let mean = shown.mean(|image, _| reflected_image(light, image, point, normal, view, spread));
    let cosine = normal.dot(view).max(S::from_f64(0.0));
    let weight = schlick(S::from_f64(0.0), cosine);
    let scaled = |factor: S| shown.value(mean.map(|channel| channel * factor));
    Answer::new(scaled(value)).with_schlick(scaled(value * weight))
}

fn vector<S: Scalar>(v: [f64; 3]) -> Vec3<S> {
    v.map(S::from_f64).into()
}
