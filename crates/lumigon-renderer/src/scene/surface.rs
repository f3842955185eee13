//! What a ray meets.

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use super::{AlphaMode, Material, Mesh, Scene, TextureRef};

/// A surface point as a ray sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample {
    /// World-space position.
    pub position: Vec3,
    /// Unit normal of the triangle's plane, towards the viewer.
    pub geometric_normal: Vec3,
    /// Unit normal to shade with: interpolated and normal-mapped. It never faces away from the
    /// viewer: where it would, it is bent back to the silhouette.
    pub shading_normal: Vec3,
    /// Linear RGB base colour.
    pub base_color: Vec3,
    /// 0 dielectric to 1 metal.
    pub metallic: f32,
    /// Square root of the GGX width alpha, 0 to 1.
    pub perceptual_roughness: f32,
    /// Strength of the dielectric reflection, 0 to 1.
    pub specular: f32,
    /// Linear RGB that multiplies the dielectric's reflectance at normal incidence.
    pub specular_color: Vec3,
    /// Index of refraction, at least 1, or 0 for an infinite one.
    pub ior: f32,
    /// How much wider the specular lobe is along [`SurfaceSample::tangent`] than across, 0 to 1.
    pub anisotropy_strength: f32,
    /// Unit vector at right angles to the shading normal, along which the specular lobe is wider;
    /// zero where the lobe is isotropic. Its sign means nothing.
    pub tangent: Vec3,
    /// Width of the diffuse lobe's facets, 0 (Lambertian) to 1.
    pub diffuse_roughness: f32,
    /// Linear RGB reflectance of the fibres over the surface.
    pub sheen_color: Vec3,
    /// Square root of the sheen's alpha, 0 to 1.
    pub sheen_perceptual_roughness: f32,
    /// How much of the surface is coated, 0 to 1.
    pub clearcoat: f32,
    /// Square root of the coat's GGX width, 0 to 1.
    pub clearcoat_perceptual_roughness: f32,
    /// Unit normal of the coat, which never faces away from the viewer either.
    pub clearcoat_normal: Vec3,
    /// Linear RGB radiance towards the viewer, beneath any coat: 0 behind a face that emits from its front alone.
    pub emissive: Vec3,
    /// 1 where there is a surface, 0 where an alpha mask cuts it out or the viewer is behind a
    /// single-sided face.
    pub opacity: f32,
    /// The viewer sees the triangle's front, from where it runs counter-clockwise.
    pub front: bool,
    /// Shown as its base colour, unlit.
    pub unlit: bool,
}

impl Scene {
    /// The surface where a ray meets a triangle. `barycentrics` weigh the triangle's second and
    /// third corners; `ray_direction` runs towards the surface and need not be a unit vector.
    ///
    /// # Panics
    /// Where there is no such mesh or triangle.
    #[must_use]
    pub fn surface(
        &self,
        mesh: usize,
        triangle: usize,
        barycentrics: Vec2,
        ray_direction: Vec3,
    ) -> SurfaceSample {
        let mesh = &self.meshes[mesh];
        let material = &self.materials[mesh.material];
        let corners = mesh.triangles[triangle];
        let point = Point {
            mesh,
            corners,
            weights: weights(barycentrics),
        };
        let outward = geometric_normal(mesh.corners(triangle));
        let front = outward.dot(ray_direction) <= 0.0;
        let towards_viewer = -ray_direction.normalize_or(-outward);
        let side = if front { 1.0 } else { -1.0 };

        let normal = point
            .blend3(&mesh.normals)
            .and_then(Vec3::try_normalize)
            .unwrap_or(outward);
        let mapped = match &material.normal_texture {
            Some(texture) => self.mapped_normal(&point, normal, texture, material.normal_scale),
            None => normal,
        };
        let shading_normal = bent_to_silhouette(mapped * side, towards_viewer);

        let base_color = self.base_color(&point, material);
        let (mut metallic, mut perceptual_roughness) =
            (material.metallic, material.perceptual_roughness);
        if let Some(texture) = &material.metallic_roughness_texture {
            let texel = self.texel(&point, texture);
            perceptual_roughness *= texel.y;
            metallic *= texel.z;
        }
        let (anisotropy_strength, direction) = self.anisotropy(&point, normal, material);
        let emits = front || material.double_sided;
        let mut emissive = if emits && !material.unlit {
            material.emissive
        } else {
            Vec3::ZERO
        };
        if let Some(texture) = &material.emissive_texture
            && emissive != Vec3::ZERO
        {
            emissive *= self.texel(&point, texture).xyz();
        }
        SurfaceSample {
            position: point.blend3(&mesh.positions).unwrap_or_default(),
            geometric_normal: outward * side,
            shading_normal,
            base_color: base_color.xyz(),
            metallic,
            perceptual_roughness,
            specular: material.specular * self.factor(&point, &material.specular_texture).w,
            specular_color: material.specular_color
                * self.factor(&point, &material.specular_color_texture).xyz(),
            ior: material.ior,
            anisotropy_strength,
            tangent: if anisotropy_strength > 0.0 {
                tangent_frame(shading_normal, direction, 1.0)
                    .map_or_else(|| shading_normal.any_orthonormal_vector(), |(t, _)| t)
            } else {
                Vec3::ZERO
            },
            diffuse_roughness: material.diffuse_roughness
                * self.factor(&point, &material.diffuse_roughness_texture).x,
            sheen_color: material.sheen_color
                * self.factor(&point, &material.sheen_color_texture).xyz(),
            sheen_perceptual_roughness: material.sheen_perceptual_roughness
                * self.factor(&point, &material.sheen_roughness_texture).w,
            clearcoat: material.clearcoat * self.factor(&point, &material.clearcoat_texture).x,
            clearcoat_perceptual_roughness: material.clearcoat_perceptual_roughness
                * self.factor(&point, &material.clearcoat_roughness_texture).y,
            clearcoat_normal: if material.clearcoat > 0.0 {
                let mapped = match &material.clearcoat_normal_texture {
                    Some(texture) => {
                        let scale = material.clearcoat_normal_scale;
                        self.mapped_normal(&point, normal, texture, scale)
                    }
                    None => normal,
                };
                bent_to_silhouette(mapped * side, towards_viewer)
            } else {
                shading_normal
            },
            emissive,
            opacity: opacity(material, base_color.w, front),
            front,
            unlit: material.unlit,
        }
    }

    /// [`SurfaceSample::opacity`] alone, for rays that only ask whether something is there.
    ///
    /// # Panics
    /// Where there is no such mesh or triangle.
    #[must_use]
    pub fn opacity(
        &self,
        mesh: usize,
        triangle: usize,
        barycentrics: Vec2,
        ray_direction: Vec3,
    ) -> f32 {
        let mesh = &self.meshes[mesh];
        let material = &self.materials[mesh.material];
        let front = material.double_sided
            || geometric_normal(mesh.corners(triangle)).dot(ray_direction) <= 0.0;
        if !matches!(material.alpha_mode, AlphaMode::Mask { .. }) {
            return opacity(material, 1.0, front);
        }
        let point = Point {
            mesh,
            corners: mesh.triangles[triangle],
            weights: weights(barycentrics),
        };
        opacity(material, self.base_color(&point, material).w, front)
    }

    fn base_color(&self, point: &Point<'_>, material: &Material) -> Vec4 {
        let mut color = material.base_color;
        if let Some(texture) = &material.base_color_texture {
            color *= self.texel(point, texture);
        }
        if let Some(vertex_color) = point.blend(&point.mesh.colors) {
            color *= vertex_color;
        }
        color
    }

    fn texel(&self, point: &Point<'_>, texture: &TextureRef) -> Vec4 {
        let texcoord = point.blend2(&point.mesh.texcoords[texture.texcoord]);
        self.textures[texture.texture].sample(texture.transform.apply(texcoord.unwrap_or_default()))
    }

    /// A texture's texel, or ones.
    fn factor(&self, point: &Point<'_>, texture: &Option<TextureRef>) -> Vec4 {
        texture
            .as_ref()
            .map_or(Vec4::ONE, |texture| self.texel(point, texture))
    }

    /// How much wider the specular lobe is in one direction, and that direction: 0 where the
    /// surface has none.
    fn anisotropy(&self, point: &Point<'_>, normal: Vec3, material: &Material) -> (f32, Vec3) {
        let mut strength = material.anisotropy_strength;
        if strength == 0.0 {
            return (0.0, Vec3::ZERO);
        }
        // Without a texture of its own the direction shares the normal texture's frame, which is
        // the surface's tangent space where the file has no tangents.
        let texture = material.anisotropy_texture.or(material.normal_texture);
        let frame = point.tangent_space(normal, &texture.unwrap_or_default());
        let Some((tangent, bitangent)) = frame else {
            return (strength, Vec3::ZERO);
        };
        let mut direction = Vec2::X;
        if let Some(texture) = &material.anisotropy_texture {
            let texel = self.texel(point, texture);
            strength *= texel.z;
            direction = (texel.xy() * 2.0 - 1.0).normalize_or(Vec2::X);
        }
        let turned = Vec2::from_angle(material.anisotropy_rotation).rotate(direction);
        (strength, tangent * turned.x + bitangent * turned.y)
    }

    /// The normal texture applied in the surface's tangent space.
    fn mapped_normal(
        &self,
        point: &Point<'_>,
        normal: Vec3,
        texture: &TextureRef,
        scale: f32,
    ) -> Vec3 {
        let Some((tangent, bitangent)) = point.tangent_space(normal, texture) else {
            return normal;
        };
        let texel = self.texel(point, texture).xyz() * 2.0 - 1.0;
        let mapped = tangent * (texel.x * scale) + bitangent * (texel.y * scale) + normal * texel.z;
        mapped.try_normalize().unwrap_or(normal)
    }
}

/// A point of a triangle, by the weights of its corners.
struct Point<'a> {
    mesh: &'a Mesh,
    corners: [u32; 3],
    weights: [f32; 3],
}

macro_rules! blend {
    ($name:ident, $vector:ty) => {
        /// The attribute here, or `None` where the mesh lacks it.
        fn $name(&self, attribute: &[$vector]) -> Option<$vector> {
            let [a, b, c] = self.corners.map(|i| attribute.get(i as usize).copied());
            let [wa, wb, wc] = self.weights;
            Some(a? * wa + b? * wb + c? * wc)
        }
    };
}

impl Point<'_> {
    blend!(blend2, Vec2);
    blend!(blend3, Vec3);
    blend!(blend, Vec4);

    /// Unit tangent and bitangent: the file's or, without those, of the triangle's own texture
    /// coordinates as the texture's transform leaves them; `None` without either.
    fn tangent_space(&self, normal: Vec3, texture: &TextureRef) -> Option<(Vec3, Vec3)> {
        if let Some(tangent) = self.blend(&self.mesh.tangents) {
            return tangent_frame(normal, tangent.xyz(), tangent.w);
        }
        let uvs = &self.mesh.texcoords[texture.texcoord];
        if uvs.is_empty() {
            return None;
        }
        let uv = self
            .corners
            .map(|i| texture.transform.apply(uvs[i as usize]));
        let p = self.corners.map(|i| self.mesh.positions[i as usize]);
        let (along_u, handedness) = texture_gradient(p, uv, normal);
        tangent_frame(normal, along_u, handedness)
    }
}

fn weights(barycentrics: Vec2) -> [f32; 3] {
    [
        1.0 - barycentrics.x - barycentrics.y,
        barycentrics.x,
        barycentrics.y,
    ]
}

/// Unit normal on the side from which the corners run counter-clockwise; Y where they are aligned.
fn geometric_normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    // Scaled first: the cross product of a small triangle's edges underflows in f32.
    let (u, v) = (b - a, c - a);
    let size = u.abs().max(v.abs()).max_element();
    (u / size).cross(v / size).normalize_or(Vec3::Y)
}

fn opacity(material: &Material, alpha: f32, front: bool) -> f32 {
    let cut = matches!(material.alpha_mode, AlphaMode::Mask { cutoff } if alpha < cutoff);
    if cut || !(front || material.double_sided) {
        0.0
    } else {
        1.0
    }
}

/// The direction on the triangle along which u grows, and the sign that makes
/// `sign * normal × tangent` the direction along which v falls: glTF's v runs down the image,
/// the bitangent of its normal maps up it.
fn texture_gradient([p0, p1, p2]: [Vec3; 3], [t0, t1, t2]: [Vec2; 3], normal: Vec3) -> (Vec3, f32) {
    let (e1, e2) = (p1 - p0, p2 - p0);
    let (d1, d2) = (t1 - t0, t2 - t0);
    let orientation = d1.perp_dot(d2).signum();
    let tangent = (e1 * d2.y - e2 * d1.y) * orientation;
    let bitangent = (e1 * d2.x - e2 * d1.x) * orientation;
    let handedness = normal.cross(tangent).dot(bitangent).signum();
    (tangent, handedness)
}

/// Unit tangent and bitangent at right angles to `normal`, or `None` where the tangent is along it.
fn tangent_frame(normal: Vec3, tangent: Vec3, handedness: f32) -> Option<(Vec3, Vec3)> {
    let tangent = tangent.try_normalize()?;
    let tangent = (tangent - normal * normal.dot(tangent)).try_normalize()?;
    let handedness = if handedness < 0.0 { -1.0 } else { 1.0 };
    Some((tangent, normal.cross(tangent) * handedness))
}

/// Interpolated and mapped normals may face away from a viewer who sees the face: such a normal is
/// turned towards the viewer until it is just visible.
#[inline]
fn bent_to_silhouette(normal: Vec3, towards_viewer: Vec3) -> Vec3 {
    const LEAST_COSINE: f32 = 1e-3;
    let cosine = normal.dot(towards_viewer);
    if cosine >= LEAST_COSINE {
        return normal;
    }
    (normal + towards_viewer * (LEAST_COSINE - cosine)).normalize_or(towards_viewer)
}
