//! Goal: effects on what is observed change that alone.
//! Setup: the 15 psi row, 12 nodes, half a second; each effect of the catalogue that acts on what is
//! observed, at its default or, where that is off, at half its scale.
//! Expected: states, tip and energies to the same bits as without it; the points seen where its law
//! says, with velocities that are their own rates.

use efam_core::forward::{Run, uniform};
use efam_experiments::release::Point;
use models::effects::{CATALOGUE, Place};
use models::model::Model;
use tests::{paper, paper_spec, simulate};

fn run() -> Run {
    Run { points: vec![Point::Tip, Point::Along(0.55)], energy: true, ..Run::release(0.5, 100.0) }
}

fn sensors() -> impl Iterator<Item = Model> {
    let of_sensor = CATALOGUE.iter().filter(|effect| effect.about().places == [Place::Sensor]);
    of_sensor.map(|effect| {
        let mut spec = paper_spec(15.0, 12, &[("rayleigh_mass.alpha", 1.0)]);
        let values = effect.about().parameters.iter().map(|p| {
            let on = if Some(p.default) == p.null_value { 0.5 * p.scale } else { p.default };
            (p.name.to_owned(), on)
        });
        spec.effects.push((effect.about().name.to_owned(), values.collect()));
        Model::new(&spec).expect("valid")
    })
}

#[test]
fn the_rod_itself_is_untouched() {
    let plain = simulate(&paper(15.0, 12, &[("rayleigh_mass.alpha", 1.0)]), &run());
    assert!(plain.seen_tip.is_empty());
    assert!(sensors().count() >= 5);
    for model in sensors() {
        let name = model.effects.last().expect("there").effect.about().name;
        let found = simulate(&model, &run());
        assert_eq!(found.states, plain.states, "{name}");
        assert_eq!((&found.tip, &found.energy), (&plain.tip, &plain.energy), "{name}");
        assert_ne!(found.points, plain.points, "{name}");
        let first: Vec<_> = found.points.iter().map(|points| points[0]).collect();
        assert_eq!(found.seen_tip, first, "{name}");
    }
}

/// Two degrees, a per cent and two millimetres, put together by hand in the order in which they act
/// between rod and recording, however the model names them.
#[test]
fn points_are_seen_where_the_laws_say() {
    let effects = [
        ("scale.relative_error", 0.01),
        ("frame_tilt.angle", 0.035),
        ("out_of_plane.lost_share", 0.02),
        ("marker_offset.across", 0.002),
        ("marker_offset.along", -0.001),
        ("clock.rate_error", 0.0),
    ];
    let run = run();
    let found = simulate(&paper(15.0, 12, &effects), &run);
    let plain = simulate(&paper(15.0, 12, &[]), &run);
    for s in 0..run.samples.len() {
        let state = plain.state(s);
        let angle = state.q[state.q.len() - 1];
        for (point, is_tip) in [(0, true), (1, false)] {
            let [mut x, mut z] = plain.points[s][point];
            if is_tip {
                x += -0.001 * angle.cos() - 0.002 * angle.sin();
                z += -0.001 * angle.sin() + 0.002 * angle.cos();
            }
            x *= 0.98;
            let (sin, cos) = 0.035f64.sin_cos();
            let due = [1.01 * (cos * x - sin * z), 1.01 * (sin * x + cos * z)];
            for (found, due) in found.points[s][point].iter().zip(due) {
                assert!((found - due).abs() < 1e-15, "sample {s}, point {point}: {found}, due {due}");
            }
        }
    }
}

/// A recording that starts 30 ms late with a clock that loses 4 %: what it has at its time t is the
/// plain path at 30 ms + 1.04 t, which goes on beyond the end of the run. One that starts early shows
/// the rod held.
#[test]
fn a_clock_shows_the_path_at_another_time() {
    let run = run();
    let at = |recorded: f64, offset: f64| offset + 1.04 * recorded;
    for offset in [0.03, -0.05] {
        let found = simulate(&paper(15.0, 12, &[("clock.rate_error", 0.04), ("clock.offset", offset)]), &run);
        let plain = paper(15.0, 12, &[]);
        let samples: Vec<f64> = run.samples.iter().map(|t| at(*t, offset).max(0.0)).collect();
        let last = samples[samples.len() - 1];
        let shifted = simulate(&plain, &Run { duration: last, samples, ..run.clone() });
        assert_eq!(found.points.len(), run.samples.len());
        for (s, (found, due)) in found.points.iter().zip(&shifted.points).enumerate() {
            for (found, due) in found.as_flattened().iter().zip(due.as_flattened()) {
                // Two runs with other last steps, each to its tolerance.
                assert!((found - due).abs() < 1e-6, "sample {s}: {found}, due {due}");
            }
        }
        // A second of the recording is 1.04 s of the rod's.
        for (s, (found, due)) in found.point_velocities.iter().zip(&shifted.point_velocities).enumerate() {
            for (found, due) in found.as_flattened().iter().zip(due.as_flattened()) {
                assert!((found - 1.04 * due).abs() < 1e-3, "sample {s}: {found} m/s, due {due}");
            }
        }
    }
}

/// Velocities against central differences over 2e-4 s of the recording: of second order, some 1e-5 of
/// the velocity for the swing at 8 rad/s, and more for the bends that the release sends along the rod.
#[test]
fn velocities_are_rates_of_what_is_seen() {
    for model in sensors() {
        let name = model.effects.last().expect("there").effect.about().name;
        let h = 1e-4;
        let times = uniform(0.4, 10.0).into_iter().skip(1).flat_map(|t| [t - h, t, t + h]).collect();
        let found = simulate(&model, &Run { samples: times, tolerance: 1e-9, ..run() });
        for middle in (1..found.times.len()).step_by(3) {
            for point in 0..2 {
                let at = |sample: usize| found.points[sample][point];
                for c in 0..2 {
                    let difference = (at(middle + 1)[c] - at(middle - 1)[c]) / (2.0 * h);
                    let velocity = found.point_velocities[middle][point][c];
                    assert!((velocity - difference).abs() < 2e-3, "{name}: {velocity}, {difference}");
                }
            }
        }
    }
}
