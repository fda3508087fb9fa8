//! What is drawn and plotted of a run.

use std::collections::VecDeque;

use ::rerun::{
    Arrows2D, BarChart, LineStrip2D, LineStrips2D, Points2D, RecordingStream, RecordingStreamResult, Scalars,
};
use models::snapshot::Snapshot;

use super::Scene;
use super::blueprint::{Bounds, Layout};
use super::entities::{
    BODY, ENERGY, FORCE, FORCES, MOMENT_ALONG, MOMENT_AT_ROOT, NODES, PAYLOAD, ROD, TIMELINE, TIP,
    TIP_HEIGHT, TRAIL,
};
use super::scenery::{SIM, Scenery, key_place, milli, payload_radius, round_up, single};

/// Geometry changes no faster than a screen; plots get every sample.
const GEOMETRY_INTERVAL: f64 = 0.0195; // s, a little below every second sample at 100 Hz

/// Past that the tip's trail shows, s.
const TRAIL_TIME: f64 = 1.5;

/// Draws into a recording what changes, and remembers what that takes.
pub struct Drawing {
    scene: Scene,
    layout: Layout,
    /// Where the tip was, and when.
    trail: VecDeque<(f64, [f32; 2])>,
    next_geometry: f64,
    /// Force that the longest arrow represents, N.
    longest_force: f64,
    knows_mesh: bool,
}

impl Drawing {
    /// Sends the layout and all that does not move.
    pub fn begin(recording: &RecordingStream, scene: &Scene, live: bool) -> RecordingStreamResult<Self> {
        let beyond = scene.body_length_m.max(scene.payload_com_m + payload_radius(scene));
        let reach = 1.15 * (scene.rod_length_m + beyond);
        let layout = Layout {
            bounds: Bounds::hanging(reach),
            duration: scene.duration_s,
            has_effects: !scene.effects.is_empty(),
            live,
        };
        layout.send(recording)?;
        let scenery = Scenery { recording, scene, layout: &layout };
        scenery.draw()?;
        end_static(recording);
        Ok(Self {
            scene: scene.clone(),
            layout,
            trail: VecDeque::new(),
            next_geometry: f64::NEG_INFINITY,
            longest_force: 0.0,
            knows_mesh: false,
        })
    }

    /// Draws and plots one instant.
    pub fn log(&mut self, recording: &RecordingStream, snapshot: &Snapshot) -> RecordingStreamResult<()> {
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
            recording.log(format!("{ENERGY}/sim/supplied"), &Scalars::single(1e3 * e.supplied))?;
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

    fn draw(&mut self, recording: &RecordingStream, snapshot: &Snapshot) -> RecordingStreamResult<()> {
        let Some(&end) = snapshot.nodes.last() else {
            return Ok(());
        };
        let (sin, cos) = snapshot.body_angle.sin_cos();
        let along_body = |length: f64| [end[0] + length * cos, end[1] + length * sin];
        let fitting_end = along_body(self.scene.body_length_m);

        let seen = (snapshot.nodes.iter()).chain([&fitting_end, &snapshot.tip]);
        if seen.fold(false, |grown, &point| self.layout.bounds.widen(point) | grown) {
            self.layout.send(recording)?;
        }

        let nodes: Vec<[f32; 2]> = snapshot.nodes.iter().copied().map(single).collect();
        recording.log(ROD, &LineStrips2D::new([LineStrip2D::from_iter(nodes.iter().copied())]))?;
        recording.log(NODES, &Points2D::new(nodes.iter().copied()))?;
        if self.scene.body_length_m > 0.0 {
            let fitting = [single(end), single(fitting_end)];
            recording.log(BODY, &LineStrips2D::new([fitting]))?;
        }
        if self.scene.payload_kg > 0.0 {
            let payload = single(along_body(self.scene.payload_com_m));
            recording.log(PAYLOAD, &Points2D::new([payload]))?;
        }
        self.draw_tip(recording, snapshot.time, single(snapshot.tip))?;
        self.draw_moment(recording, snapshot)?;
        self.draw_forces(recording, snapshot, &nodes)
    }

    fn draw_tip(
        &mut self,
        recording: &RecordingStream,
        time: f64,
        tip: [f32; 2],
    ) -> RecordingStreamResult<()> {
        recording.log(TIP, &Points2D::new([tip]))?;
        self.trail.push_back((time, tip));
        while (self.trail.front()).is_some_and(|(then, _)| *then < time - TRAIL_TIME) {
            self.trail.pop_front();
        }
        let trail = LineStrip2D::from_iter(self.trail.iter().map(|(_, tip)| *tip));
        recording.log(TRAIL, &LineStrips2D::new([trail]))
    }

    fn draw_moment(&mut self, recording: &RecordingStream, snapshot: &Snapshot) -> RecordingStreamResult<()> {
        let path = format!("{MOMENT_ALONG}/sim");
        if !self.knows_mesh {
            self.knows_mesh = true;
            let arc = arc_lengths(&snapshot.nodes, self.scene.rod_length_m);
            let width = (0.8e3 * self.scene.rod_length_m) as f32 / arc.len().max(2) as f32;
            let widths = vec![width; arc.len()];
            let arc: Vec<f64> = arc.iter().map(|length| 1e3 * length).collect();
            let axis = BarChart::update_fields().with_abscissa(arc).with_widths(widths).with_color(SIM);
            recording.log_static(path.as_str(), &axis)?;
            end_static(recording);
        }
        let moment: Vec<f64> = snapshot.bending_moment.iter().map(|m| 1e3 * m).collect();
        recording.log(path, &BarChart::new(moment))
    }

    /// The length of an arrow goes with the root of its force, for the end fitting's forces exceed
    /// those of the other nodes by far. All shrink when a force exceeds all before.
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
        if longest > self.longest_force {
            self.longest_force = round_up(longest);
            self.draw_scale(recording)?;
        }
        for effect in &self.scene.effects {
            let vectors = force_of(snapshot, effect).iter().map(|f| self.arrow(*f));
            let arrows = Arrows2D::from_vectors(vectors).with_origins(nodes.iter().copied());
            recording.log(format!("{FORCES}/{effect}"), &arrows)?;
        }
        Ok(())
    }

    fn draw_scale(&self, recording: &RecordingStream) -> RecordingStreamResult<()> {
        let forces = [self.longest_force, 0.1 * self.longest_force];
        let places = [0.0, 1.0].map(|row| single(key_place(&self.layout, row)));
        let scale = Arrows2D::from_vectors(forces.map(|force| self.arrow([force, 0.0])))
            .with_origins(places)
            .with_labels(forces.map(|force| format!("{} mN", milli(force))))
            .with_show_labels(true);
        recording.log(format!("{FORCES}/scale"), &scale)
    }

    fn arrow(&self, [x, z]: [f64; 2]) -> [f32; 2] {
        let force = x.hypot(z);
        if force == 0.0 || self.longest_force == 0.0 {
            return [0.0; 2];
        }
        let length = 0.4 * self.scene.rod_length_m * (force / self.longest_force).sqrt();
        single([length * x / force, length * z / force])
    }
}

fn log_scalars(
    recording: &RecordingStream,
    path: &str,
    values: impl IntoIterator<Item = f64>,
) -> RecordingStreamResult<()> {
    recording.log(format!("{path}/sim"), &Scalars::new(values))
}

/// Closes the chunks: one with both static and changing data would be split in random order, and
/// equal runs should give equal files.
fn end_static(recording: &RecordingStream) {
    let _ = recording.flush_async(); // what cannot be delivered is reported at the end
}

/// Force of an effect on each node, N; none if the snapshot does not have it.
fn force_of<'a>(snapshot: &'a Snapshot, effect: &str) -> &'a [[f64; 2]] {
    (snapshot.effect_forces.iter()).find(|force| force.effect == effect).map_or(&[], |force| &force.force)
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
