//! Answers: what a question comes to.

use std::sync::LazyLock;

use lumigon::{
    AnisotropicLtc, AnisotropicLtcTable, DiffuseMethod, ImageMethod, LightImage, LocalOcclusion,
    Ltc, LtcSum, LtcTable, MINIMUM_SHEEN_ALPHA, PolygonLight, PreparedLtc, Scalar, Sides, Vec3,
    form_factor, irradiance, light_vector, ltc_form_factor, ltc_mean_image, projected_area,
    solid_angle,
};
use lumigon_reference::{Polygon, Tolerance};
use serde::Serialize;

use super::Precision;
use super::mirror;
use super::question::{Quantity, Question, QuestionError, TableName, Texture};

/// A number in the precision it was computed in: the shortest digits that give it back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Number {
    /// Single precision.
    F32(f32),
    /// Double precision.
    F64(f64),
}

impl From<f32> for Number {
    fn from(number: f32) -> Self {
        Self::F32(number)
    }
}

impl From<f64> for Number {
    fn from(number: f64) -> Self {
        Self::F64(number)
    }
}

impl Number {
    fn is_finite(self) -> bool {
        match self {
            Self::F32(number) => number.is_finite(),
            Self::F64(number) => number.is_finite(),
        }
    }
}

/// What was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// One number.
    Scalar(Number),
    /// A vector in the frame of the question, or linear RGB.
    Vector([Number; 3]),
}

impl<N: Into<Number>> From<N> for Value {
    fn from(number: N) -> Self {
        Self::Scalar(number.into())
    }
}

impl Value {
    fn is_finite(self) -> bool {
        match self {
            Self::Scalar(number) => number.is_finite(),
            Self::Vector(numbers) => numbers.into_iter().all(Number::is_finite),
        }
    }
}

/// The answer to one question.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// What was asked for.
    pub value: Value,
    /// The same weighted by Schlick's (1 - h.v)^5, for quantities that have it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub schlick: Option<Value>,
    /// Light scattered more than once, for a multiple-scattering albedo of 1; the value is that of
    /// light scattered once by a white surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub multiple: Option<Value>,
}

impl Answer {
    pub(super) fn new(value: impl Into<Value>) -> Self {
        Self {
            value: value.into(),
            schlick: None,
            multiple: None,
        }
    }

    pub(super) fn with_schlick(self, schlick: impl Into<Value>) -> Self {
        Self {
            schlick: Some(schlick.into()),
            ..self
        }
    }

    fn with_multiple(self, multiple: impl Into<Value>) -> Self {
        Self {
            multiple: Some(multiple.into()),
            ..self
        }
    }

    fn is_finite(&self) -> bool {
        let values = [Some(self.value), self.schlick, self.multiple];
        values.into_iter().flatten().all(Value::is_finite)
    }
}

/// Answers one line.
///
/// # Errors
/// Where the line is no question that has an answer.
pub fn answer(line: &str, precision: Precision) -> Result<Answer, QuestionError> {
    let question: Question = serde_json::from_str(line)?;
    let answer = match cubature(&question)? {
        Some(answer) => answer,
        None => {
            let sides = match question.two_sided {
                true => Sides::Both,
                false => Sides::Front,
            };
            let light = PolygonLight::new(&question.loops, sides)?;
            match precision {
                Precision::F64 => closed_form::<f64>(&question, &light)?,
                Precision::F32 => closed_form::<f32>(&question, &light)?,
            }
        }
    };
    match answer.is_finite() {
        true => Ok(answer),
        false => Err(QuestionError::NotFinite),
    }
}

/// Writes an answer, or why there is none, as one JSON object.
pub(super) fn write(answer: &Result<Answer, QuestionError>, out: &mut Vec<u8>) {
    #[derive(Serialize)]
    struct Error {
        error: String,
    }
    let written = match answer {
        Ok(answer) => serde_json::to_writer(out, answer),
        Err(error) => serde_json::to_writer(
            out,
            &Error {
                error: error.to_string(),
            },
        ),
    };
    written.expect("numbers and strings can be written to memory");
}

/// What a light shows, if it is not uniform.
pub(super) struct Shown<S> {
    image: Option<LightImage<S>>,
    method: ImageMethod,
}

impl<S: Scalar + Into<Number>> Shown<S> {
    fn new(question: &Question, light: &PolygonLight<f64>) -> Result<Self, QuestionError> {
        let texture = question.texture.as_ref();
        Ok(Self {
            image: texture.map(|texture| texture.image(light)).transpose()?,
            method: texture.map_or_else(ImageMethod::default, Texture::method),
        })
    }

    /// The mean colour by a method; white without an image.
    pub(super) fn mean(&self, mean: impl FnOnce(&LightImage<S>, ImageMethod) -> [S; 3]) -> [S; 3] {
        let image = self.image.as_ref();
        image.map_or([S::from_f64(1.0); 3], |image| mean(image, self.method))
    }

    /// A colour with an image, a number without.
    pub(super) fn value(&self, color: [S; 3]) -> Value {
        match self.image {
            Some(_) => Value::Vector(color.map(Into::into)),
            None => color[0].into().into(),
        }
    }
}

fn closed_form<S: Scalar + Into<Number>>(
    question: &Question,
    light: &PolygonLight<f64>,
) -> Result<Answer, QuestionError> {
    let shown = Shown::<S>::new(question, light)?;
    let light = &light.cast::<S>()?;
    let point = vector::<S>(question.point);
    for (coordinate, value) in <[S; 3]>::from(point).into_iter().zip(question.point) {
        if !coordinate.to_f64().is_finite() {
            return Err(QuestionError::OutOfRange {
                field: "point",
                value,
                range: "what this precision holds",
            });
        }
    }
    let normal = || question.normal().map(vector);
    let weighted = |value: S, normal, method: DiffuseMethod| {
        let mean =
            shown.mean(|image, images| method.mean_image(light, image, point, normal, images));
        Answer::new(shown.value(mean.map(|channel| value * channel)))
    };
    Ok(match question.quantity {
        Quantity::Irradiance => {
            let value = irradiance(light, point, normal()?);
            weighted(value, normal()?, DiffuseMethod::default())
        }
        Quantity::FormFactor => {
            let value = form_factor(light, point, normal()?);
            weighted(value, normal()?, DiffuseMethod::default())
        }
        Quantity::LightVector if shown.image.is_some() => return Err(QuestionError::NoTexture),
        Quantity::LightVector => Answer::new(Value::Vector(
            <[S; 3]>::from(light_vector(light, point)).map(Into::into),
        )),
        Quantity::SolidAngle => {
            // No horizon: any normal does.
            let up = Vec3::from([0.0, 0.0, 1.0].map(S::from_f64));
            let occlusion = LocalOcclusion::Circle;
            let whole = DiffuseMethod::LightVector { occlusion };
            weighted(solid_angle(light, point), up, whole)
        }
        Quantity::ProjectedArea => {
            let (basis, occlusion) = (question.basis()?, question.occlusion.into());
            let value = projected_area(light, point, normal()?, basis, occlusion);
            let by_area = DiffuseMethod::ProjectedArea { basis, occlusion };
            weighted(value, normal()?, by_area)
        }
        Quantity::Ltc => ltc(question, light, &shown, point)?,
        Quantity::ReflectedInclusion => mirror::inclusion(question, light, &shown, point)?,
        Quantity::ReflectedDistance => mirror::distance(question, light, &shown, point)?,
        Quantity::Ggx | Quantity::GgxAnisotropic | Quantity::Charlie | Quantity::Eon => {
            unreachable!("answered by cubature")
        }
    })
}

/// A fitted table's response, the sum over its lobes.
fn ltc<S: Scalar + Into<Number>>(
    question: &Question,
    light: &PolygonLight<S>,
    shown: &Shown<S>,
    point: Vec3<S>,
) -> Result<Answer, QuestionError> {
    static GGX: LazyLock<LtcTable<1>> = LazyLock::new(LtcTable::ggx);
    static GGX_2: LazyLock<LtcTable<2>> = LazyLock::new(LtcTable::ggx_2);
    static ANISOTROPIC: LazyLock<AnisotropicLtcTable> = LazyLock::new(AnisotropicLtcTable::ggx);
    static CHARLIE: LazyLock<LtcTable<1>> = LazyLock::new(LtcTable::charlie);
    static EON: LazyLock<LtcTable<1>> = LazyLock::new(LtcTable::eon);

    let seen = Seen::new(question, light, shown, point)?;
    let cosine = seen.cosine();
    Ok(match question.table()? {
        TableName::Ggx => {
            let perceptual_roughness = question.perceptual_roughness()? as f32;
            let [value, schlick] = seen.sum(&GGX.lookup(perceptual_roughness, cosine));
            Answer::new(value).with_schlick(schlick)
        }
        TableName::Ggx2 => {
            let perceptual_roughness = question.perceptual_roughness()? as f32;
            let [value, schlick] = seen.sum(&GGX_2.lookup(perceptual_roughness, cosine));
            Answer::new(value).with_schlick(schlick)
        }
        TableName::GgxAnisotropic => {
            let tangent = question.tangent()?;
            let alphas = question.alphas()?.map(|alpha| alpha as f32);
            let [value, schlick] = seen.anisotropic(&ANISOTROPIC, alphas, tangent);
            Answer::new(value).with_schlick(schlick)
        }
        TableName::Charlie => {
            let perceptual_roughness = question.sheen_perceptual_roughness()? as f32;
            Answer::new(seen.sum(&CHARLIE.lookup(perceptual_roughness, cosine))[0])
        }
        TableName::Eon => {
            let diffuse_roughness = question.diffuse_roughness()? as f32;
            let [single, multiple] = seen.sum(&EON.lookup(diffuse_roughness, cosine));
            Answer::new(single).with_multiple(multiple)
        }
    })
}

/// A light at a point of a surface that somebody looks at.
struct Seen<'a, S> {
    light: &'a PolygonLight<S>,
    shown: &'a Shown<S>,
    point: Vec3<S>,
    normal: [f64; 3],
    view: [f64; 3],
}

impl<'a, S: Scalar + Into<Number>> Seen<'a, S> {
    fn new(
        question: &Question,
        light: &'a PolygonLight<S>,
        shown: &'a Shown<S>,
        point: Vec3<S>,
    ) -> Result<Self, QuestionError> {
        Ok(Self {
            light,
            shown,
            point,
            normal: question.normal()?,
            view: question.view()?,
        })
    }

    fn cosine(&self) -> f32 {
        Vec3::from(self.normal).dot(Vec3::from(self.view)) as f32
    }

    /// By channel of what the light shows.
    fn form_factor(&self, lobe: &PreparedLtc<S>) -> [S; 3] {
        // From below its horizon nobody sees a surface; the tables end there.
        if self.cosine() <= 0.0 {
            return [S::from_f64(0.0); 3];
        }
        let form_factor = ltc_form_factor(self.light, self.point, lobe);
        let mean = self
            .shown
            .mean(|image, images| ltc_mean_image(self.light, image, self.point, lobe, images));
        mean.map(|channel| form_factor * channel)
    }

    /// Response and weighted response.
    fn sum<const LOBES: usize>(&self, sum: &LtcSum<LOBES>) -> [Value; 2] {
        let mut response = [[S::from_f64(0.0); 3]; 2];
        for lobe in sum.iter() {
            let lobe = Ltc {
                shading_to_cosine: lobe.shading_to_cosine.map(wide),
                amplitude: wide(lobe.amplitude),
                schlick: wide(lobe.schlick),
            };
            let prepared = PreparedLtc::new(&lobe, vector(self.normal), vector(self.view));
            for (channel, form_factor) in self.form_factor(&prepared).into_iter().enumerate() {
                response[0][channel] += lobe.amplitude * form_factor;
                response[1][channel] += lobe.schlick * form_factor;
            }
        }
        response.map(|color| self.shown.value(color))
    }

    /// The same for two widths, along and across the tangent.
    fn anisotropic(
        &self,
        table: &AnisotropicLtcTable,
        alphas: [f32; 2],
        tangent: [f64; 3],
    ) -> [Value; 2] {
        let [normal, view, tangent] = [self.normal, self.view, tangent].map(Vec3::from);
        let bitangent = normal.cross(tangent);
        let local = [tangent, bitangent, normal].map(|axis| axis.dot(view) as f32);
        let lobe = table.lookup(alphas, Vec3::from(local));
        let lobe = AnisotropicLtc {
            shading_to_cosine: lobe.shading_to_cosine.map(|row| row.map(wide)),
            amplitude: wide(lobe.amplitude),
            schlick: wide(lobe.schlick),
        };
        let [tangent, bitangent, normal] =
            [tangent, bitangent, normal].map(|axis| vector(axis.into()));
        let form_factor = self.form_factor(&lobe.prepare(tangent, bitangent, normal));
        [lobe.amplitude, lobe.schlick].map(|weight| {
            self.shown
                .value(form_factor.map(|channel| weight * channel))
        })
    }
}

fn wide<S: Scalar>(number: f32) -> S {
    S::from_f64(number.into())
}

fn vector<S: Scalar>(v: [f64; 3]) -> Vec3<S> {
    Vec3::from(v.map(S::from_f64))
}

/// A BRDF itself by cubature, in double precision; `None` for what has a closed form.
fn cubature(question: &Question) -> Result<Option<Answer>, QuestionError> {
    let light = || Polygon::new(&question.loops, question.two_sided);
    let (point, tolerance) = (question.point, Tolerance::default());
    let is_brdf = matches!(
        question.quantity,
        Quantity::Ggx | Quantity::GgxAnisotropic | Quantity::Charlie | Quantity::Eon
    );
    if is_brdf && question.texture.is_some() {
        return Err(QuestionError::NoTexture);
    }
    Ok(Some(match question.quantity {
        Quantity::Ggx => {
            let (normal, view) = (question.normal()?, question.view()?);
            let alpha = question.alpha()?;
            let integral =
                lumigon_reference::ggx(&light()?, point, normal, view, alpha, tolerance)?;
            Answer::new(integral.value).with_schlick(integral.schlick)
        }
        Quantity::GgxAnisotropic => {
            let (normal, view) = (question.normal()?, question.view()?);
            let (tangent, alphas) = (question.tangent()?, question.alphas()?);
            let integral = lumigon_reference::ggx_anisotropic(
                &light()?,
                point,
                normal,
                tangent,
                view,
                alphas,
                tolerance,
            )?;
            Answer::new(integral.value).with_schlick(integral.schlick)
        }
        Quantity::Charlie => {
            let (normal, view) = (question.normal()?, question.view()?);
            let perceptual_roughness = question.sheen_perceptual_roughness()?;
            let alpha = (perceptual_roughness * perceptual_roughness).max(MINIMUM_SHEEN_ALPHA);
            let integral =
                lumigon_reference::charlie(&light()?, point, normal, view, alpha, tolerance)?;
            Answer::new(integral.value)
        }
        Quantity::Eon => {
            let (normal, view) = (question.normal()?, question.view()?);
            let roughness = question.diffuse_roughness()?;
            let integral =
                lumigon_reference::eon(&light()?, point, normal, view, roughness, tolerance)?;
            Answer::new(integral.single).with_multiple(integral.multiple)
        }
        _ => return Ok(None),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(rest: &str) -> String {
        let line = format!(
            r#"{{"loops":[[[-1,1,-1],[1,1,-1],[1,1,1],[-1,1,1]]],"point":[0,0,0],{rest}}}"#
        );
        let mut out = Vec::new();
        write(&answer(&line, Precision::F64), &mut out);
        String::from_utf8(out).unwrap()
    }

    fn value(rest: &str) -> f64 {
        let json: serde_json::Value = serde_json::from_str(&ask(rest)).unwrap();
        json["value"].as_f64().unwrap()
    }

    #[test]
    fn every_quantity_of_a_square_overhead() {
        // A face of a cube about the point: a sixth of the sphere.
        let sixth = 4.0 * std::f64::consts::PI / 6.0;
        assert!((value(r#""quantity":"solid_angle""#) - sixth).abs() < 1e-14);
        // From the cube's centre an edge subtends acos(1/3), in a plane at 45 degrees.
        let edge = (1.0_f64 / 3.0).acos();
        let exact = 4.0 * edge * 0.5 * (0.5_f64).sqrt();
        let normal = r#""normal":[0,1,0],"quantity":"#;
        assert!((value(&format!(r#"{normal}"irradiance""#)) - exact).abs() < 1e-14);
        let form_factor = value(&format!(r#"{normal}"form_factor""#));
        assert!((form_factor * std::f64::consts::PI - exact).abs() < 1e-14);
        let area = format!(r#"{normal}"projected_area","basis":"optimal""#);
        assert!((value(&area) - 4.0).abs() < 1e-12);
        let area = format!(r#"{normal}"projected_area","basis":"biased","bias":1"#);
        assert!((value(&area) - 1.0).abs() < 1e-12);
        let json: serde_json::Value =
            serde_json::from_str(&ask(r#""quantity":"light_vector""#)).unwrap();
        assert!((json["value"][1].as_f64().unwrap() - exact).abs() < 1e-14);
        let rough = r#""view":[0,1,0],"perceptual_roughness":0.8,"quantity":"#;
        let rough = format!(r#""normal":[0,1,0],{rough}"#);
        let (ltc, ggx) = (format!(r#"{rough}"ltc""#), format!(r#"{rough}"ggx""#));
        assert!((value(&ltc) - value(&ggx)).abs() < 0.02);
        assert!(ask(&ggx).contains(r#","schlick":"#));
    }

    #[test]
    fn errors_name_the_field() {
        for (rest, expected) in [
            (r#""quantity":"irradiance""#, "missing field `normal`"),
            (
                r#""quantity":"irradiance","normal":[0,2,0]"#,
                "`normal` has length 2.0",
            ),
            (r#""quantity":"brightness""#, "unknown variant `brightness`"),
            (
                r#""quantity":"irradiance","normal":[0,1]"#,
                "invalid length 2",
            ),
            (
                r#""quantity":"projected_area","normal":[0,1,0]"#,
                "missing field `basis`",
            ),
            (
                r#""quantity":"projected_area","normal":[0,1,0],"basis":"biased","bias":-1"#,
                "`bias` is -1.0",
            ),
            (
                r#""quantity":"ltc","normal":[0,1,0],"view":[0,1,0],"perceptual_roughness":1.5"#,
                "`perceptual_roughness` is 1.5",
            ),
            (
                r#""quantity":"ltc","normal":[0,1,0],"view":[0,1,0],"table":"ggx-3""#,
                r#"`table` is \"ggx-3\": give ggx, ggx-2"#,
            ),
            (
                r#""quantity":"ltc","normal":[0,1,0],"view":[0,1,0],"table":"charlie""#,
                "missing field `sheen_perceptual_roughness`",
            ),
            (
                r#""quantity":"eon","normal":[0,1,0],"view":[0,1,0],"diffuse_roughness":-1"#,
                "`diffuse_roughness` is -1.0: give 0 to 1",
            ),
            (
                r#""quantity":"ggx_anisotropic","normal":[0,1,0],"view":[0,1,0],"perceptual_roughness":0.5,"anisotropy_strength":0.5,"tangent":[0.6,0.8,0]"#,
                "`tangent` leans out of the surface",
            ),
            (
                r#""quantity":"irradiance","normal":[0,1e999,0]"#,
                "number out of range",
            ),
        ] {
            let answer = ask(rest);
            assert!(answer.starts_with(r#"{"error":""#), "{answer}");
            assert!(answer.contains(expected), "{answer}");
        }
    }

    #[test]
    fn textures_colour_every_quantity() {
        let frame = r#""corner":[-1,1,-1],"edge_u":[2,0,0],"edge_v":[0,0,2]"#;
        // Red grows along x, green along z, blue is everywhere.
        let texels: Vec<Vec<[f64; 3]>> = (0..8)
            .map(|j| {
                (0..8)
                    .map(|i| [f64::from(i) + 0.5, f64::from(j) + 0.5, 4.0])
                    .collect()
            })
            .collect();
        let texels = serde_json::to_string(&texels).unwrap();
        for method in ["lookup", "1x1", "2x2", "3x3", "4x4"] {
            let texture = format!(r#""texture":{{"texels":{texels},{frame},"method":"{method}"}}"#);
            let surface = r#""normal":[0,1,0],"view":[0,1,0],"perceptual_roughness":0.6"#;
            for quantity in [
                r#""quantity":"irradiance""#,
                r#""quantity":"form_factor""#,
                r#""quantity":"solid_angle""#,
                r#""quantity":"projected_area","basis":"optimal""#,
                r#""quantity":"ltc""#,
                r#""quantity":"ltc","table":"ggx-2""#,
                r#""quantity":"ltc","table":"ggx-anisotropic","anisotropy_strength":0,"tangent":[1,0,0]"#,
                r#""quantity":"ltc","table":"eon","diffuse_roughness":0.5"#,
            ] {
                let white = value(&format!("{surface},{quantity}"));
                let shown = ask(&format!("{surface},{quantity},{texture}"));
                let shown: serde_json::Value = serde_json::from_str(&shown).unwrap();
                for channel in 0..3 {
                    // Seen from below its middle, all are 4 on average.
                    let found = shown["value"][channel].as_f64().unwrap();
                    assert!(
                        (found / white - 4.0).abs() < 5e-3,
                        "{method} {quantity} {shown}"
                    );
                }
            }
        }
        for (texture, expected) in [
            (
                format!(r#"{{"texels":[],{frame}}}"#),
                "an image of 0 x 0 texels",
            ),
            (
                format!(r#"{{"texels":[[[1,1,1],[1,1,1]],[[1,1,1]]],{frame}}}"#),
                "row 1 has 1 texels, the first 2",
            ),
            (
                format!(r#"{{"texels":[[[1,-1,1]]],{frame}}}"#),
                "texel (0, 0) is -1",
            ),
            (
                r#"{"texels":[[[1,1,1]]],"corner":[0,1,0],"edge_u":[1,0,0],"edge_v":[0,1,0]}"#
                    .to_owned(),
                "edges span no parallelogram",
            ),
        ] {
            let rest = format!(r#""quantity":"irradiance","normal":[0,1,0],"texture":{texture}"#);
            assert!(ask(&rest).contains(expected), "{}", ask(&rest));
        }
        let one = format!(r#""texture":{{"texels":[[[1,1,1]]],{frame}}}"#);
        let refused = ask(&format!(r#""quantity":"light_vector",{one}"#));
        assert!(refused.contains("leave the texture out"), "{refused}");
    }

    #[test]
    fn numbers_of_single_precision_are_short() {
        let line = r#"{"quantity":"irradiance","normal":[0,0,1],"point":[0,0,0],
            "loops":[[[0,0,2],[0,1,2],[1,0,2]]]}"#;
        let Value::Scalar(Number::F32(single)) = answer(line, Precision::F32).unwrap().value else {
            panic!("not in single precision")
        };
        let Value::Scalar(Number::F64(double)) = answer(line, Precision::F64).unwrap().value else {
            panic!("not in double precision")
        };
        assert!((f64::from(single) - double).abs() < 1e-7);
        let mut out = Vec::new();
        write(&answer(line, Precision::F32), &mut out);
        assert_eq!(out, format!("{{\"value\":{single}}}").into_bytes());
    }

    #[test]
    fn too_far_for_single_precision_is_an_error() {
        let line = r#"{"quantity":"solid_angle","point":[0,0,1e60],
            "loops":[[[0,0,2],[0,1,2],[1,0,2]]]}"#;
        assert!(answer(line, Precision::F64).is_ok());
        let error = answer(line, Precision::F32).unwrap_err().to_string();
        assert!(error.contains("`point` is 1e60"), "{error}");
    }
}
