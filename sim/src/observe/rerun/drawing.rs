//! What is drawn and plotted of a run.

use std::collections::VecDeque;

use ::rerun::{
    Arrows2D, BarChart, ComponentIdentifier, DynamicArchetype, LineStrip2D, LineStrips2D, Points2D, Radius,
    RecordingStream, RecordingStreamResult, Scalars, SeriesLines, Text, Transform3D,
};
use models::snapshot::Snapshot;

use super::Scene;
use super::blueprint::{Bounds, Layout};

pub(super) const TIMELINE: &str = "sim_time";
pub(super) const TIP_HEIGHT: &str = "plots/tip_height_mm";
pub(super) const ENERGY: &str = "plots/energy_mJ";
pub(super) const MOMENT_AT_ROOT: &str = "plots/moment_at_root_mNm";
pub(super) const MOMENT_ALONG: &str = "plots/moment_along_rod_mNm";
pub(super) const FORCE: &str = "plots/effect_force_mN";
pub(super) const FORCES: &str = "world/fam/sim/forces";
pub(super) const GRID_LABELS: &str = "world/grid/labels";

const ROD: &str = "world/fam/sim/rod";
const NODES: &str = "world/fam/sim/nodes";
const BODY: &str = "world/fam/sim/end_fitting";
const PAYLOAD: &str = "world/fam/sim/payload";
const TIP: &str = "world/fam/sim/tip";
const TRAIL: &str = "world/fam/sim/tip_trail";

/// Colours of Okabe and Ito that can be told apart with any eyes, on dark and light ground.
const SKY: u32 = 0x56B4_E9FF;
const ORANGE: u32 = 0xE69F_00FF;
const GREEN: u32 = 0x009E_73FF;
const PURPLE: u32 = 0xCC79_A7FF;
const VERMILION: u32 = 0xD55E_00FF;
const BLUE: u32 = 0x0072_B2FF;
const GREY: u32 = 0x9999_99FF;
const SIM: u32 = SKY;
const EFFECT_COLORS: [u32; 6] = [SKY, ORANGE, GREEN, PURPLE, VERMILION, BLUE];

/// Geometry changes no faster than a screen; plots get every sample.
const GEOMETRY_INTERVAL: f64 = 0.0195; // s, a little below every second sample at 100 Hz

/// Past that the tip's trail shows, s.
const TRAIL_TIME: f64 = 1.5;

/// Draws into a recording what changes, and remembers what that takes.
pub(super) struct Drawing {
    scene: Scene,
    layout: Layout,
    trail: VecDeque<[f32; 2]>,
    next_geometry: f64,
    /// Force of the longest arrow so far, rounded up, N.
    arrow_force: f64,
    knows_mesh: bool,
}

impl Drawing {
    /// Sends the layout and all that does not move.
    pub fn begin(
        recording: &RecordingStream,
        scene: &Scene,
        live: bool,
    ) -> RecordingStreamResult<Self> {
        let beyond = scene
            .body_length_m
            .max(scene.payload_com_m + payload_radius(scene));
        let reach = 1.15 * (scene.rod_length_m + beyond);
        let layout = Layout {
            bounds: Bounds::hanging(reach),
            grid_mm: 1e3 * round_up(reach / 5.0),
            has_effects: !scene.effects.is_empty(),
            live,
        };
        layout.send(recording)?;
        let drawing = Self {
            scene: scene.clone(),
            layout,
            trail: VecDeque::new(),
            next_geometry: f64::NEG_INFINITY,
            arrow_force: 0.0,
            knows_mesh: false,
        };
        drawing.tell_about_run(recording)?;
        drawing.draw_surroundings(recording)?;
        drawing.style_rod(recording)?;
        drawing.style_plots(recording)?;
        Ok(drawing)
    }

    /// Draws and plots one instant.
    pub fn log(
        &mut self,
        recording: &RecordingStream,
        snapshot: &Snapshot,
    ) -> RecordingStreamResult<()> {
        recording.set_duration_secs(TIMELINE, snapshot.time);
        self.plot(recording, snapshot)?;
        if snapshot.time >= self.next_geometry {
            self.next_geometry = snapshot.time + GEOMETRY_INTERVAL;
            self.draw(recording, snapshot)?;
        }
        Ok(())
    }

    fn plot(&self, recording: &RecordingStream, snapshot: &Snapshot) -> RecordingStreamResult<()> {
        let e = &snapshot.energy;
        let total = e.kinetic + e.elastic + e.potential + e.dissipated + e.supplied;
        let energies = [e.kinetic, e.elastic, e.potential, e.dissipated, total];
        log_scalars(recording, TIP_HEIGHT, [1e3 * snapshot.tip[1]])?;
        log_scalars(recording, ENERGY, energies.map(|energy| 1e3 * energy))?;
        if e.supplied != 0.0 {
            recording.log(
                format!("{ENERGY}/sim/supplied"),
                &Scalars::single(1e3 * e.supplied),
            )?;
        }
        if let Some(root) = snapshot.bending_moment.first() {
            log_scalars(recording, MOMENT_AT_ROOT, [1e3 * root])?;
        }
        if self.layout.has_effects {
            let total = |effect: &&str| {
                let force = force_of(snapshot, effect);
                1e3 * force.iter().map(|[x, z]| x.hypot(*z)).sum::<f64>()
            };
            log_scalars(recording, FORCE, self.scene.effects.iter().map(total))?;
        }
        Ok(())
    }

    fn draw(
        &mut self,
        recording: &RecordingStream,
        snapshot: &Snapshot,
    ) -> RecordingStreamResult<()> {
        let Some(&end) = snapshot.nodes.last() else {
            return Ok(());
        };
        let (sin, cos) = snapshot.body_angle.sin_cos();
        let along_body = |length: f64| [end[0] + length * cos, end[1] + length * sin];
        let fitting_end = along_body(self.scene.body_length_m);

        let seen = (snapshot.nodes.iter()).chain([&fitting_end, &snapshot.tip]);
        if seen.fold(false, |grown, &point| {
            self.layout.bounds.widen(point) | grown
        }) {
            self.layout.send(recording)?;
        }

        let nodes: Vec<[f32; 2]> = snapshot.nodes.iter().copied().map(single).collect();
        recording.log(
            ROD,
            &LineStrips2D::new([LineStrip2D::from_iter(nodes.iter().copied())]),
        )?;
        recording.log(NODES, &Points2D::new(nodes.iter().copied()))?;
        if self.scene.body_length_m > 0.0 {
            let fitting = [single(end), single(fitting_end)];
            recording.log(BODY, &LineStrips2D::new([fitting]))?;
        }
        if self.scene.payload_kg > 0.0 {
            let payload = single(along_body(self.scene.payload_com_m));
            recording.log(PAYLOAD, &Points2D::new([payload]))?;
        }
        self.draw_tip(recording, single(snapshot.tip))?;
        self.draw_moment(recording, snapshot)?;
        self.draw_forces(recording, snapshot, &nodes)
    }

    fn draw_tip(
        &mut self,
        recording: &RecordingStream,
        tip: [f32; 2],
    ) -> RecordingStreamResult<()> {
        recording.log(TIP, &Points2D::new([tip]))?;
        self.trail.push_back(tip);
        if self.trail.len() as f64 > TRAIL_TIME / GEOMETRY_INTERVAL {
            self.trail.pop_front();
        }
        let trail = LineStrip2D::from_iter(self.trail.iter().copied());
        recording.log(TRAIL, &LineStrips2D::new([trail]))
    }

    fn draw_moment(
        &mut self,
        recording: &RecordingStream,
        snapshot: &Snapshot,
    ) -> RecordingStreamResult<()> {
        let path = format!("{MOMENT_ALONG}/sim");
        if !self.knows_mesh {
            self.knows_mesh = true;
            let arc = arc_lengths(&snapshot.nodes, self.scene.rod_length_m);
            let width = (0.8e3 * self.scene.rod_length_m) as f32 / arc.len().max(2) as f32;
            let widths = vec![width; arc.len()];
            let arc: Vec<f64> = arc.iter().map(|length| 1e3 * length).collect();
            let axis = BarChart::update_fields()
                .with_abscissa(arc)
                .with_widths(widths)
                .with_color(SIM);
            recording.log_static(path.as_str(), &axis)?;
        }
        let moment: Vec<f64> = snapshot.bending_moment.iter().map(|m| 1e3 * m).collect();
        recording.log(path, &BarChart::new(moment))
    }

    /// One length of arrow for all effects; it shrinks when a force exceeds all before.
    fn draw_forces(
        &mut self,
        recording: &RecordingStream,
        snapshot: &Snapshot,
        nodes: &[[f32; 2]],
    ) -> RecordingStreamResult<()> {
        let longest = (snapshot.effect_forces.iter())
            .flat_map(|effect| &effect.force)
            .map(|[x, z]| x.hypot(*z))
            .filter(|force| force.is_finite())
            .fold(0.0, f64::max);
        let arrow_length = 0.3 * self.scene.rod_length_m;
        if longest > self.arrow_force {
            self.arrow_force = round_up(longest);
            let scale = Arrows2D::update_fields()
                .with_vectors([single([arrow_length, 0.0])])
                .with_origins([single(self.corner(0.0))])
                .with_labels([format!("{:.4} mN", 1e3 * self.arrow_force)]);
            recording.log(format!("{FORCES}/scale"), &scale)?;
        }
        if self.arrow_force == 0.0 {
            return Ok(());
        }
        let m_per_n = arrow_length / self.arrow_force;
        for effect in &self.scene.effects {
            let vectors = (force_of(snapshot, effect).iter())
                .map(|[x, z]| single([m_per_n * x, m_per_n * z]));
            let arrows = Arrows2D::from_vectors(vectors).with_origins(nodes.iter().copied());
            recording.log(format!("{FORCES}/{effect}"), &arrows)?;
        }
        Ok(())
    }

    fn tell_about_run(&self, recording: &RecordingStream) -> RecordingStreamResult<()> {
        recording.send_recording_name(self.scene.run_name.as_str())?;
        let mut properties = DynamicArchetype::new("run");
        for (name, value) in &self.scene.properties {
            if let Ok(name) = ComponentIdentifier::try_new(name) {
                properties = properties.with_component::<Text>(name, [value.clone()]);
            }
        }
        recording.send_property("run", &properties)
    }

    fn draw_surroundings(&self, recording: &RecordingStream) -> RecordingStreamResult<()> {
        // Data are z up; a 2D view's second axis points down.
        recording.log_static("world", &Transform3D::from_scale([1.0, -1.0, 1.0]))?;

        let height = 0.3 * self.scene.rod_length_m;
        let step = height / 6.0;
        let hatch = (0..=6).map(|k| {
            let z = -0.5 * height + step * f64::from(k);
            vec![single([0.0, z]), single([-step, z - step])]
        });
        let wall = vec![single([0.0, -0.5 * height]), single([0.0, 0.5 * height])];
        let clamp = LineStrips2D::new([wall].into_iter().chain(hatch))
            .with_colors([GREY])
            .with_radii([2.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0].map(Radius::new_ui_points));
        recording.log_static("world/clamp", &clamp)?;

        let Bounds { x, z } = self.layout.bounds;
        let spacing = 1e-3 * self.layout.grid_mm;
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
        recording.log_static("world/grid", &grid)?;

        let below = inside(x).map(|at| ([at, z[0]], format!("{:.0}", 1e3 * at)));
        let beside = inside(z).map(|at| ([x[0], at], format!("{:.0}", 1e3 * at)));
        let (points, labels): (Vec<_>, Vec<_>) = below.chain(beside).unzip();
        let labels = Points2D::new(points.into_iter().map(single))
            .with_labels(labels)
            .with_show_labels(true)
            .with_colors([GREY])
            .with_radii([Radius::new_ui_points(1.0)]);
        recording.log_static(GRID_LABELS, &labels)
    }

    fn style_rod(&self, recording: &RecordingStream) -> RecordingStreamResult<()> {
        let line = |color: u32, radius: Radius, order: f32| {
            LineStrips2D::update_fields()
                .with_colors([color])
                .with_radii([radius])
                .with_draw_order(order)
        };
        let point = |color: u32, radius: Radius, order: f32| {
            Points2D::update_fields()
                .with_colors([color])
                .with_radii([radius])
                .with_draw_order(order)
        };
        let points = Radius::new_ui_points;
        let payload = Radius::new_scene_units(payload_radius(&self.scene) as f32);
        recording.log_static(TRAIL, &line(0xD55E_0080, points(1.0), 5.0))?;
        recording.log_static(PAYLOAD, &point(PURPLE, payload, 10.0))?;
        recording.log_static(ROD, &line(SIM, points(3.0), 20.0))?;
        recording.log_static(BODY, &line(GREY, points(5.0), 25.0))?;
        recording.log_static(NODES, &point(BLUE, points(2.0), 30.0))?;
        recording.log_static(TIP, &point(VERMILION, points(5.0), 40.0))?;

        let arrows = |color: u32| {
            Arrows2D::update_fields()
                .with_colors([color])
                .with_radii([points(2.0)])
                .with_draw_order(35.0)
        };
        recording.log_static(format!("{FORCES}/scale"), &arrows(GREY))?;
        for ((effect, color), row) in self.effects().zip(1..) {
            recording.log_static(format!("{FORCES}/{effect}"), &arrows(color))?;
            let key = Points2D::new([single(self.corner(f64::from(row)))])
                .with_labels([effect])
                .with_show_labels(true)
                .with_colors([color])
                .with_radii([points(4.0)]);
            recording.log_static(format!("{FORCES}/{effect}/key"), &key)?;
        }
        Ok(())
    }

    fn style_plots(&self, recording: &RecordingStream) -> RecordingStreamResult<()> {
        let line = |path: &str, name: &str, color: u32| {
            let line = SeriesLines::new().with_names([name]).with_colors([color]);
            recording.log_static(path, &line.with_widths([1.5]))
        };
        line(&format!("{TIP_HEIGHT}/sim"), "tip z, sim", SIM)?;
        line(&format!("{MOMENT_AT_ROOT}/sim"), "root moment, sim", SIM)?;
        line(&format!("{ENERGY}/sim/supplied"), "supplied", BLUE)?;
        let energies = SeriesLines::new()
            .with_names(["kinetic", "elastic", "potential", "dissipated", "total"])
            .with_colors([SKY, ORANGE, GREEN, PURPLE, GREY])
            .with_widths([1.5; 5]);
        recording.log_static(format!("{ENERGY}/sim"), &energies)?;
        let (names, colors): (Vec<_>, Vec<_>) = self.effects().unzip();
        let widths = vec![1.5; names.len()];
        let forces = SeriesLines::new()
            .with_names(names)
            .with_colors(colors)
            .with_widths(widths);
        recording.log_static(format!("{FORCE}/sim"), &forces)
    }

    fn effects(&self) -> impl Iterator<Item = (&'static str, u32)> {
        let colors = EFFECT_COLORS.into_iter().cycle();
        self.scene.effects.iter().copied().zip(colors)
    }

    /// Place of a line of the key to the forces, W, m.
    fn corner(&self, row: f64) -> [f64; 2] {
        let Bounds { x, z } = self.layout.bounds;
        let size = x[1] - x[0];
        [x[0] + 0.06 * size, z[1] - (0.06 + 0.07 * row) * size]
    }
}

fn log_scalars(
    recording: &RecordingStream,
    path: &str,
    values: impl IntoIterator<Item = f64>,
) -> RecordingStreamResult<()> {
    recording.log(format!("{path}/sim"), &Scalars::new(values))
}

/// Force of an effect on each node, N; none if the snapshot does not have it.
fn force_of<'a>(snapshot: &'a Snapshot, effect: &str) -> &'a [[f64; 2]] {
    (snapshot.effect_forces.iter())
        .find(|force| force.effect == effect)
        .map_or(&[], |force| &force.force)
}

/// Radius of a steel ball of the payload's mass, m.
fn payload_radius(scene: &Scene) -> f64 {
    let density = 7850.0; // kg/m^3
    (scene.payload_kg.max(0.0) / density * 0.75 / std::f64::consts::PI).cbrt()
}

/// Distance of each node from the clamp along the undeformed rod, m.
fn arc_lengths(nodes: &[[f64; 2]], rod_length: f64) -> Vec<f64> {
    let mut arc = vec![0.0];
    for edge in nodes.windows(2) {
        let length = (edge[1][0] - edge[0][0]).hypot(edge[1][1] - edge[0][1]);
        arc.push(arc[arc.len() - 1] + length);
    }
    let stretch = arc[arc.len() - 1] / rod_length;
    arc.iter().map(|length| length / stretch).collect()
}

/// Next 1, 2 or 5 times a power of ten.
fn round_up(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    steps
        .into_iter()
        .find(|step| *step >= value)
        .unwrap_or(value)
}

fn single([x, z]: [f64; 2]) -> [f32; 2] {
    [x as f32, z as f32]
}
