//! What does not move: who the run is, clamp, grid, keys, and the colours of what moves.

use ::rerun::{
    Arrows2D, ComponentIdentifier, DynamicArchetype, LineStrips2D, Points2D, Radius, RecordingStream,
    RecordingStreamResult, SeriesLines, Text, Transform3D,
};

use super::Scene;
use super::blueprint::{Bounds, Layout};
use super::entities::{
    BODY, ENERGY, FORCE, FORCES, GRID_LABELS, MOMENT_AT_ROOT, NODES, PAYLOAD, ROD, TIP, TIP_HEIGHT, TRAIL,
};

/// Colours of Okabe and Ito that can be distinguished with any eyes, on dark and light ground.
const SKY: u32 = 0x56B4_E9FF;
const ORANGE: u32 = 0xE69F_00FF;
const GREEN: u32 = 0x009E_73FF;
const PURPLE: u32 = 0xCC79_A7FF;
pub(super) const VERMILION: u32 = 0xD55E_00FF;
pub(super) const BLUE: u32 = 0x0072_B2FF;
pub(super) const GREY: u32 = 0x9999_99FF;
pub(super) const SIM: u32 = SKY;
const EFFECT_COLORS: [u32; 6] = [SKY, ORANGE, GREEN, PURPLE, VERMILION, BLUE];

/// Draws once.
pub(super) struct Scenery<'a> {
    pub recording: &'a RecordingStream,
    pub scene: &'a Scene,
    pub layout: &'a Layout,
}

impl Scenery<'_> {
    /// Draws all of it.
    pub fn draw(&self) -> RecordingStreamResult<()> {
        self.tell_about_run()?;
        self.draw_surroundings()?;
        self.style_rod()?;
        self.style_forces()?;
        self.style_plots()
    }

    fn tell_about_run(&self) -> RecordingStreamResult<()> {
        self.recording.send_recording_name(self.scene.run_name.as_str())?;
        let mut properties = DynamicArchetype::new("run");
        for (name, value) in &self.scene.properties {
            if let Ok(name) = ComponentIdentifier::try_new(name) {
                properties = properties.with_component::<Text>(name, [value.clone()]);
            }
        }
        self.recording.send_property("run", &properties)
    }

    fn draw_surroundings(&self) -> RecordingStreamResult<()> {
        // Data are z up; a 2D view's second axis points down.
        self.recording.log_static("world", &Transform3D::from_scale([1.0, -1.0, 1.0]))?;

        self.recording.log_static("world/clamp", &clamp(0.3 * self.scene.rod_length_m))?;

        let x = self.layout.bounds.x;
        let z = x; // for a rod that rises, too
        let spacing = round_up((x[1] - x[0]) / 16.0);
        let inside = |[low, high]: [f64; 2]| {
            ((low / spacing).ceil() as i32..=(high / spacing).floor() as i32)
                .map(move |k| f64::from(k) * spacing)
        };
        let upright = inside(x).map(|at| [single([at, z[0]]), single([at, z[1]])]);
        let level = inside(z).map(|at| [single([x[0], at]), single([x[1], at])]);
        let grid = LineStrips2D::new(upright.chain(level))
            .with_colors([0x8080_8050_u32])
            .with_radii([Radius::new_ui_points(0.5)])
            .with_draw_order(-10.0);
        self.recording.log_static("world/grid", &grid)?;

        let margin = 0.04 * (x[1] - x[0]);
        let (left, bottom) = (x[0] + margin, z[0] + margin);
        let below = (inside(x).filter(|at| *at > left + margin)).map(|at| ([at, bottom], milli(at)));
        let beside = (inside(z).filter(|at| *at > bottom + margin)).map(|at| ([left, at], milli(at)));
        let (points, labels): (Vec<_>, Vec<_>) = below.chain(beside).unzip();
        let labels = Points2D::new(points.into_iter().map(single))
            .with_labels(labels)
            .with_show_labels(true)
            .with_colors([GREY])
            .with_radii([Radius::new_ui_points(1.0)]);
        self.recording.log_static(GRID_LABELS, &labels)
    }

    fn style_rod(&self) -> RecordingStreamResult<()> {
        let line = |color: u32, radius: Radius, order: f32| {
            LineStrips2D::update_fields().with_colors([color]).with_radii([radius]).with_draw_order(order)
        };
        let point = |color: u32, radius: Radius, order: f32| {
            Points2D::update_fields().with_colors([color]).with_radii([radius]).with_draw_order(order)
        };
        let points = Radius::new_ui_points;
        let payload = Radius::new_scene_units(payload_radius(self.scene) as f32);
        self.recording.log_static(TRAIL, &line(0xD55E_0080, points(1.0), 5.0))?;
        self.recording.log_static(PAYLOAD, &point(PURPLE, payload, 10.0))?;
        self.recording.log_static(ROD, &line(SIM, points(3.0), 20.0))?;
        self.recording.log_static(BODY, &line(GREY, points(5.0), 25.0))?;
        self.recording.log_static(NODES, &point(BLUE, points(2.0), 30.0))?;
        self.recording.log_static(TIP, &point(VERMILION, points(5.0), 40.0))
    }

    fn style_forces(&self) -> RecordingStreamResult<()> {
        let arrows = |path: &str, color: u32| {
            let arrows = Arrows2D::update_fields()
                .with_colors([color])
                .with_radii([Radius::new_ui_points(2.0)])
                .with_draw_order(35.0);
            self.recording.log_static(format!("{FORCES}/{path}"), &arrows)
        };
        arrows("scale", GREY)?;
        for (row, (effect, color)) in self.effects().enumerate() {
            arrows(effect, color)?;
            // Two lines above belong to the scale.
            let key = Points2D::new([single(key_place(self.layout, row as f64 + 2.0))])
                .with_labels([effect])
                .with_show_labels(true)
                .with_colors([color])
                .with_radii([Radius::new_ui_points(4.0)]);
            (self.recording).log_static(format!("{FORCES}/{effect}/key"), &key)?;
        }
        Ok(())
    }

    fn style_plots(&self) -> RecordingStreamResult<()> {
        let line = |path: &str, name: &str, color: u32| {
            let line = SeriesLines::new().with_names([name]).with_colors([color]);
            self.recording.log_static(path, &line.with_widths([1.5]))
        };
        line(&format!("{TIP_HEIGHT}/sim"), "tip z, sim", SIM)?;
        line(&format!("{MOMENT_AT_ROOT}/sim"), "root moment, sim", SIM)?;
        line(&format!("{ENERGY}/sim/supplied"), "supplied", BLUE)?;
        let energies = SeriesLines::new()
            .with_names(["kinetic", "elastic", "potential", "dissipated", "total"])
            .with_colors([SKY, ORANGE, GREEN, PURPLE, GREY])
            .with_widths([1.5; 5]);
        self.recording.log_static(format!("{ENERGY}/sim"), &energies)?;
        let (names, colors): (Vec<_>, Vec<_>) = self.effects().unzip();
        let widths = vec![1.5; names.len()];
        let forces = SeriesLines::new().with_names(names).with_colors(colors).with_widths(widths);
        self.recording.log_static(format!("{FORCE}/sim"), &forces)
    }

    fn effects(&self) -> impl Iterator<Item = (&'static str, u32)> {
        let colors = EFFECT_COLORS.into_iter().cycle();
        self.scene.effects.iter().copied().zip(colors)
    }
}

/// A wall of some height, m, at the origin.
pub(super) fn clamp(height: f64) -> LineStrips2D {
    let step = height / 6.0;
    let hatch = (0..=6).map(|k| {
        let z = -0.5 * height + step * f64::from(k);
        vec![single([0.0, z]), single([-step, z - step])]
    });
    let wall = vec![single([0.0, -0.5 * height]), single([0.0, 0.5 * height])];
    LineStrips2D::new([wall].into_iter().chain(hatch))
        .with_colors([GREY])
        .with_radii([2.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0].map(Radius::new_ui_points))
}

/// Place of a line of the key to the forces, W, m.
pub(super) fn key_place(layout: &Layout, row: f64) -> [f64; 2] {
    let Bounds { x, z } = layout.bounds;
    let size = x[1] - x[0];
    [x[0] + 0.11 * size, z[1] - (0.05 + 0.065 * row) * size]
}

/// Radius of a steel ball of the payload's mass, m.
pub(super) fn payload_radius(scene: &Scene) -> f64 {
    let density = 7850.0; // kg/m^3
    (scene.payload_kg.max(0.0) / density * 0.75 / std::f64::consts::PI).cbrt()
}

/// Next 1, 2 or 5 times a power of ten.
pub(super) fn round_up(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    steps.into_iter().find(|step| *step >= value).unwrap_or(value)
}

/// A round number in thousandths of its unit, without the dust of binary fractions.
pub(super) fn milli(value: f64) -> String {
    let thousandths = (1e9 * value).round() / 1e6;
    format!("{}", thousandths + 0.0) // no -0
}

/// A place as viewers take it.
pub(super) fn single([x, z]: [f64; 2]) -> [f32; 2] {
    [x as f32, z as f32]
}
