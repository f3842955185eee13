//! Taking hold of lights: vertices and gizmos over the picture.

use egui::{Align2, Color32, CursorIcon, Id, Pos2, Rect, Response, Sense, Stroke, Ui};
use glam::{DVec2, DVec3, Vec3};

use super::App;
use super::viewport::label;
use crate::document::outline::{self, Corner};
use crate::document::{EditError, Light, LightId, OutlineFault};

/// Points across what takes hold of a vertex.
const HANDLE: f32 = 16.0;
/// Length of a gizmo's arrows, in points.
const ARROW: f32 = 76.0;
/// How near to an edge a click is on it, in points; three times that to insert a vertex.
const NEAR: f32 = 12.0;
/// Vertices that get handles.
const MOST_HANDLES: usize = 1024;
/// Steps while the command key is held: metres, and radians.
const STEP: f64 = 0.1;
const ANGLE_STEP: f64 = std::f64::consts::PI / 12.0;

/// What the pointer does to the selected light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Tool {
    #[default]
    Shape,
    Move,
    Turn,
    Scale,
}

/// One thing to take hold of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Handle {
    Vertex(Corner),
    /// Along a direction of the world.
    Along(DVec3),
    /// In the picture's plane.
    Freely,
    /// Around a direction of the world.
    Around(DVec3),
    /// Width, height, or both.
    Size([bool; 2]),
}

/// A drag that goes on.
struct Held {
    light: LightId,
    handle: Handle,
    /// The light before it began.
    start: Light,
    /// What it came to so far: metres, radians or metres at the handle's place.
    amount: DVec3,
    /// From the pointer to the vertex, in the light's plane.
    offset: DVec2,
}

/// What is held, and what was refused.
#[derive(Default)]
pub(super) struct Hands {
    pub(super) tool: Tool,
    pub(super) vertex: Option<Corner>,
    held: Option<Held>,
    /// An outline that was refused, and why.
    refused: Option<(Vec<Vec<DVec2>>, OutlineFault)>,
}

impl Hands {
    /// Gives up what is being dragged. False where nothing is.
    pub(super) fn give_up(&mut self) -> bool {
        self.refused = None;
        self.held.take().is_some()
    }

    /// The pointer's frame, before the picture is made.
    pub(super) fn handle(&mut self, app: &mut App, ui: &Ui, picture: &Response, aspect: f32) {
        if picture.clicked() {
            self.click(app, picture, aspect);
        }
        if picture.double_clicked()
            && let Some(at) = picture.interact_pointer_pos()
        {
            self.insert_vertex(app, at, aspect);
        }
        let Some((id, light)) = app.selected_light() else {
            self.held = None;
            self.vertex = None;
            return;
        };
        let handles = self.handles(app, &light, aspect);
        for (handle, name, at) in handles {
            let rect = Rect::from_center_size(at, egui::Vec2::splat(HANDLE));
            if !app.picture_rect.intersects(rect) {
                continue;
            }
            let response = ui.interact(
                rect,
                Id::unique(("light handle", id.index(), &name)),
                Sense::click_and_drag(),
            );
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
            self.respond(app, ui, &response, handle, id, &light, aspect);
        }
    }

    #[allow(
        clippy::too_many_arguments,
        reason = "one caller, each a different thing"
    )]
    fn respond(
        &mut self,
        app: &mut App,
        ui: &Ui,
        response: &Response,
        handle: Handle,
        id: LightId,
        light: &Light,
        aspect: f32,
    ) {
        if response.hovered() {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
        if let Handle::Vertex(corner) = handle
            && (response.clicked() || response.drag_started())
        {
            self.vertex = Some(corner);
        }
        if response.drag_started() {
            let offset = match handle {
                Handle::Vertex(corner) => {
                    let vertex = light.loops[corner.loop_index][corner.vertex];
                    let pressed = ui.input(|input| input.pointer.press_origin());
                    let grabbed = pressed.and_then(|at| app.on_plane(light, at, aspect));
                    grabbed.map_or(DVec2::ZERO, |grabbed| vertex - grabbed)
                }
                _ => DVec2::ZERO,
            };
            self.held = Some(Held {
                light: id,
                handle,
                start: light.clone(),
                amount: DVec3::ZERO,
                offset,
            });
            app.begin(handle.step());
        }
        if response.dragged()
            && let Some(held) = &mut self.held
        {
            ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
            let is_stepping = ui.input(|input| input.modifiers.command);
            if let Some(new) = held.drag(app, response, aspect, is_stepping) {
                let refused = app.try_light(held.light, new.clone());
                self.refused = match refused {
                    Err(EditError::Outline(fault)) => Some((new.loops, fault)),
                    _ => None,
                };
            }
        }
        if response.drag_stopped() && self.held.take().is_some() {
            self.refused = None;
            app.end();
        }
    }

    /// What there is to take hold of, by name, and where in the window.
    fn handles(&self, app: &App, light: &Light, aspect: f32) -> Vec<(Handle, String, Pos2)> {
        let origin = light.world_from_plane.translation;
        let window = |point: DVec3| app.to_window(point.as_vec3(), aspect);
        let mut handles = Vec::new();
        match self.tool {
            Tool::Shape => {
                if light.can_reshape().is_err() {
                    return handles;
                }
                let corners = light
                    .loops
                    .iter()
                    .enumerate()
                    .flat_map(|(loop_index, points)| {
                        (0..points.len()).map(move |vertex| Corner { loop_index, vertex })
                    });
                for (i, corner) in corners.take(MOST_HANDLES).enumerate() {
                    let point = light.to_world(light.loops[corner.loop_index][corner.vertex]);
                    if let Some(at) = window(point) {
                        handles.push((Handle::Vertex(corner), format!("Vertex {}", i + 1), at));
                    }
                }
            }
            Tool::Move => {
                let length = app.metres(origin, ARROW, aspect);
                for (direction, name) in arrows(light) {
                    if let Some(at) = window(origin + direction * length) {
                        handles.push((Handle::Along(direction), format!("Move along {name}"), at));
                    }
                }
                if let Some(at) = window(origin) {
                    handles.push((Handle::Freely, "Move freely".to_owned(), at));
                }
            }
            Tool::Turn => {
                let length = app.metres(origin, ARROW, aspect);
                for (axis, name) in axes(light) {
                    if let Some(at) = window(origin + perpendicular(light, axis) * length) {
                        handles.push((Handle::Around(axis), format!("Turn about {name}"), at));
                    }
                }
            }
            Tool::Scale => {
                let (_, high) = light.bounds();
                for (sides, name) in [
                    ([true, false], "Width"),
                    ([false, true], "Height"),
                    ([true, true], "Size"),
                ] {
                    let place = DVec2::new(
                        if sides[0] { high.x } else { 0.0 },
                        if sides[1] { high.y } else { 0.0 },
                    );
                    if let Some(at) = window(light.to_world(place)) {
                        handles.push((Handle::Size(sides), name.to_owned(), at));
                    }
                }
            }
        }
        handles
    }

    fn click(&mut self, app: &mut App, picture: &Response, aspect: f32) {
        let Some(at) = picture.interact_pointer_pos() else {
            return;
        };
        let found = app.light_under(at, aspect);
        // Edges are clicked on to insert vertices: a little beside them is not nowhere.
        let is_by_edge = app
            .selected_light()
            .is_some_and(|(_, light)| edge_near(app, &light, at, aspect, NEAR).is_some());
        if found.is_none() && is_by_edge {
            return;
        }
        if let Some(open) = &mut app.open {
            if open.selected != found {
                self.vertex = None;
            }
            open.selected = found;
        }
    }

    /// A vertex on the edge nearest to a place of the window, if one is near.
    pub(super) fn insert_vertex(&mut self, app: &mut App, at: Pos2, aspect: f32) -> bool {
        let Some((id, mut light)) = app.selected_light() else {
            return false;
        };
        let Some((edge, on_edge)) = edge_near(app, &light, at, aspect, 3.0 * NEAR) else {
            return false;
        };
        let Some(corner) = outline::insert_vertex(&mut light.loops, edge, on_edge) else {
            return false;
        };
        let is_done = app.change("insert vertex", id, light);
        if is_done {
            self.vertex = Some(corner);
            self.tool = Tool::Shape;
        }
        is_done
    }

    /// Over the picture.
    pub(super) fn paint(&self, app: &App, ui: &Ui, aspect: f32) {
        let Some((_, light)) = app.selected_light() else {
            return;
        };
        let painter = ui.painter_at(app.picture_rect);
        let is_held = self.held.is_some();
        let alpha = if is_held { 150 } else { 255 };
        let color = Color32::from_rgba_unmultiplied(255, 190, 60, alpha);
        outline_shape(
            app,
            &painter,
            &light,
            &light.loops,
            Stroke::new(1.5, color),
            aspect,
        );
        if let Some((loops, fault)) = &self.refused {
            let red = Color32::from_rgb(255, 70, 60);
            outline_shape(app, &painter, &light, loops, Stroke::new(1.5, red), aspect);
            if let OutlineFault::Crossing(edges) = fault {
                for edge in edges {
                    if let Some([a, b]) = outline::edge(loops, *edge) {
                        segment(
                            app,
                            &painter,
                            [light.to_world(a), light.to_world(b)],
                            Stroke::new(4.0, red),
                            aspect,
                        );
                    }
                }
            }
            let at = app.picture_rect.center_top() + egui::vec2(0.0, 30.0);
            label(
                &painter,
                at,
                Align2::CENTER_CENTER,
                &format!("Refused: {fault}"),
            );
        }
        let origin = light.world_from_plane.translation;
        let length = app.metres(origin, ARROW, aspect);
        match self.tool {
            Tool::Move => {
                for (direction, name) in arrows(&light) {
                    let stroke = Stroke::new(2.5, axis_color(name));
                    segment(
                        app,
                        &painter,
                        [origin, origin + direction * length],
                        stroke,
                        aspect,
                    );
                }
            }
            Tool::Turn => {
                for (axis, name) in axes(&light) {
                    let stroke = Stroke::new(1.5, axis_color(name));
                    let u = perpendicular(&light, axis);
                    let v = axis.cross(u);
                    let point = |i: u32| {
                        let angle = f64::from(i) / 48.0 * std::f64::consts::TAU;
                        origin + (u * angle.cos() + v * angle.sin()) * length
                    };
                    for i in 0..48 {
                        segment(app, &painter, [point(i), point(i + 1)], stroke, aspect);
                    }
                }
            }
            Tool::Shape | Tool::Scale => {}
        }
        let pointer = ui.input(|input| input.pointer.hover_pos());
        for (handle, name, at) in self.handles(app, &light, aspect) {
            let is_near = pointer.is_some_and(|pointer| pointer.distance(at) < HANDLE * 0.6);
            let is_chosen = matches!(handle, Handle::Vertex(corner) if self.vertex == Some(corner));
            let fill = match handle {
                Handle::Along(_) | Handle::Around(_) => {
                    axis_color(name.rsplit(' ').next().unwrap_or_default())
                }
                _ if is_chosen => Color32::from_rgb(255, 120, 30),
                _ => Color32::from_gray(240),
            };
            let radius = if is_near || is_chosen { 6.0 } else { 4.5 };
            painter.circle(
                at,
                radius,
                fill,
                Stroke::new(1.5, Color32::from_black_alpha(200)),
            );
        }
    }
}

impl Handle {
    fn step(self) -> &'static str {
        match self {
            Self::Vertex(_) => "move vertex",
            Self::Along(_) | Self::Freely => "move light",
            Self::Around(_) => "turn light",
            Self::Size(_) => "scale light",
        }
    }
}

impl Held {
    /// The light as the pointer has it now; none where that cannot be said.
    fn drag(
        &mut self,
        app: &App,
        response: &Response,
        aspect: f32,
        is_stepping: bool,
    ) -> Option<Light> {
        let start = &self.start;
        let origin = start.world_from_plane.translation;
        let stepped = |x: f64, step: f64| {
            if is_stepping {
                (x / step).round() * step
            } else {
                x
            }
        };
        // How far in the window something goes that goes along a direction of the world.
        let screen = |from: DVec3, direction: DVec3| -> Option<DVec2> {
            let small = app.metres(from, 4.0, aspect);
            let a = app.to_window(from.as_vec3(), aspect)?;
            let b = app.to_window((from + direction * small).as_vec3(), aspect)?;
            Some(DVec2::new(f64::from(b.x - a.x), f64::from(b.y - a.y)) / small)
        };
        let drag = response.drag_delta();
        let drag = DVec2::new(f64::from(drag.x), f64::from(drag.y));
        let along = |per_metre: DVec2| {
            let squared = per_metre.length_squared();
            (squared > 0.0).then(|| drag.dot(per_metre) / squared)
        };
        match self.handle {
            Handle::Vertex(corner) => {
                let at =
                    app.on_plane(start, response.interact_pointer_pos()?, aspect)? + self.offset;
                let mut light = start.clone();
                let to = DVec2::new(stepped(at.x, STEP), stepped(at.y, STEP));
                outline::move_vertex(&mut light.loops, corner, to).then_some(light)
            }
            Handle::Along(direction) => {
                let here = origin + direction * self.amount.x;
                self.amount.x += along(screen(here, direction)?)?;
                Some(start.moved(direction * stepped(self.amount.x, STEP)))
            }
            Handle::Freely => {
                let here = origin + self.amount;
                let metres = app.metres(here, 1.0, aspect);
                let view = &app.open.as_ref()?.navigation;
                self.amount +=
                    (view.right().as_dvec3() * drag.x - view.up().as_dvec3() * drag.y) * metres;
                Some(start.moved(self.amount))
            }
            Handle::Around(axis) => {
                let u = perpendicular(start, axis);
                let (sin, cos) = self.amount.x.sin_cos();
                let arm = u * cos + axis.cross(u) * sin;
                let length = app.metres(origin, ARROW, aspect);
                let here = origin + arm * length;
                let per_metre = screen(here, axis.cross(arm))?;
                // Where the ring is seen from its edge, its far end is no guide.
                let floor =
                    DVec2::splat(0.2 / app.metres(here, 1.0, aspect)).length_squared() * 0.5;
                self.amount.x +=
                    drag.dot(per_metre) / per_metre.length_squared().max(floor) / length;
                Some(start.turned(axis, stepped(self.amount.x, ANGLE_STEP)))
            }
            Handle::Size(sides) => {
                let (_, high) = start.bounds();
                let at = app.on_plane(start, response.interact_pointer_pos()?, aspect)?;
                let factor = |i: usize| match (sides[i], high[i]) {
                    (true, high) if high > 0.0 => {
                        stepped(at[i].max(high * 0.01), STEP).max(high * 0.01) / high
                    }
                    _ => 1.0,
                };
                let (mut x, mut y) = (factor(0), factor(1));
                if sides == [true, true] {
                    x = x.max(y);
                    y = x;
                }
                start.scaled(x, y)
            }
        }
    }
}

/// The edge of a light nearest to a place of the window, and where on it, if it is as near as `reach` in
/// points.
fn edge_near(
    app: &App,
    light: &Light,
    at: Pos2,
    aspect: f32,
    reach: f32,
) -> Option<(Corner, DVec2)> {
    let point = app.on_plane(light, at, aspect)?;
    let (edge, on_edge, _) = outline::nearest_edge(&light.loops, point)?;
    let seen = app.to_window(light.to_world(on_edge).as_vec3(), aspect)?;
    (seen.distance(at) <= reach).then_some((edge, on_edge))
}

/// World axes and the light's own normal.
fn arrows(light: &Light) -> [(DVec3, &'static str); 4] {
    [
        (DVec3::X, "x"),
        (DVec3::Y, "y"),
        (DVec3::Z, "z"),
        (light.normal(), "normal"),
    ]
}

/// The light's own axes.
fn axes(light: &Light) -> [(DVec3, &'static str); 3] {
    let axes = light.world_from_plane.matrix3;
    [
        (axes.x_axis, "x"),
        (axes.y_axis, "y"),
        (axes.z_axis, "normal"),
    ]
}

/// Where the handle of a ring about one of the light's axes begins.
fn perpendicular(light: &Light, axis: DVec3) -> DVec3 {
    let axes = light.world_from_plane.matrix3;
    // Handles of different rings stand apart.
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis];
    let around = [(x, y), (y, z), (z, x)];
    let found = around.iter().find(|(own, _)| own.dot(axis).abs() > 0.99);
    found.map_or(axis.any_orthonormal_vector(), |&(_, next)| next)
}

fn axis_color(name: &str) -> Color32 {
    match name {
        "x" => Color32::from_rgb(240, 80, 80),
        "y" => Color32::from_rgb(110, 210, 90),
        "z" => Color32::from_rgb(90, 140, 255),
        _ => Color32::from_rgb(250, 220, 80),
    }
}

fn outline_shape(
    app: &App,
    painter: &egui::Painter,
    light: &Light,
    loops: &[Vec<DVec2>],
    stroke: Stroke,
    aspect: f32,
) {
    for points in loops {
        for (i, &a) in points.iter().enumerate() {
            let b = points[(i + 1) % points.len()];
            segment(
                app,
                painter,
                [a, b].map(|p| light.to_world(p)),
                stroke,
                aspect,
            );
        }
    }
}

/// A line of the world, as far as it is in front of the camera.
fn segment(app: &App, painter: &egui::Painter, [a, b]: [DVec3; 2], stroke: Stroke, aspect: f32) {
    let window = |p: DVec3| app.to_window(p.as_vec3(), aspect);
    let (from, to) = match (window(a), window(b)) {
        (Some(from), Some(to)) => (from, to),
        (None, None) => return,
        (seen, _) => {
            let (near, far) = if seen.is_some() { (a, b) } else { (b, a) };
            // The farthest point of it that is seen.
            let (mut inside, mut outside) = (0.0, 1.0);
            for _ in 0..24 {
                let middle = 0.5 * (inside + outside);
                match window(near.lerp(far, middle)) {
                    Some(_) => inside = middle,
                    None => outside = middle,
                }
            }
            match (window(near), window(near.lerp(far, inside))) {
                (Some(from), Some(to)) => (from, to),
                _ => return,
            }
        }
    };
    painter.line_segment([from, to], stroke);
}

impl App {
    /// The selected light, as it is now.
    pub(super) fn selected_light(&self) -> Option<(LightId, Light)> {
        let open = self.open.as_ref()?;
        let id = open.selected?;
        Some((id, open.document.light(id)?.clone()))
    }

    /// The light under a place of the window: of all that is seen there, what is nearest, or else a light
    /// that is seen from its back or from its edge.
    pub(super) fn light_under(&self, at: Pos2, aspect: f32) -> Option<LightId> {
        let open = self.open.as_ref()?;
        let place = self.to_picture(at);
        let picked = open.display.pick(open.navigation.camera(), place, aspect)?;
        open.document.light_at(picked.mesh, picked.triangle)
    }

    /// Where the pointer's ray meets a light's plane, in the plane.
    pub(super) fn on_plane(&self, light: &Light, at: Pos2, aspect: f32) -> Option<DVec2> {
        let open = self.open.as_ref()?;
        let place = self.to_picture(at);
        let (origin, direction) = open.navigation.camera().ray(place.x, place.y, aspect);
        let (origin, direction) = (origin.as_dvec3(), direction.as_dvec3());
        let normal = light.normal();
        let slope = direction.dot(normal);
        if slope.abs() < 1e-4 {
            return None;
        }
        let distance = (light.world_from_plane.translation - origin).dot(normal) / slope;
        (distance > 0.0).then(|| light.to_plane(origin + direction * distance))
    }

    /// Metres, across the view, that as many points of the window show at a place of the world.
    pub(super) fn metres(&self, at: DVec3, points: f32, aspect: f32) -> f64 {
        let Some(open) = &self.open else {
            return 1.0;
        };
        let view = &open.navigation;
        let up: Vec3 = view.up();
        let at = at.as_vec3();
        let small = (at - Vec3::from(view.camera().world_from_camera.translation))
            .length()
            .max(1e-3)
            * 1e-2;
        let height = self.picture_rect.height();
        let seen = |point| {
            view.project(point, aspect)
                .map(|(place, _)| place.y * height)
        };
        match (seen(at), seen(at + up * small)) {
            (Some(a), Some(b)) if (a - b).abs() > 1e-6 => f64::from(small * points / (a - b).abs()),
            _ => f64::from(small),
        }
    }
}
