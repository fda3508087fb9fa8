//! Where a rod at rest begins to swing because its pressure steps.
//!
//! Each step of the pressure is an event: the tip rests, begins to move near it, and swings about another rest, at which the
//! next step finds it. The pressure says where to look, the tip when it moves: the clocks of both may differ a little.

use std::ops::Range;

use super::cycles::{self, Cut, FAST, LEAST_TURNS};
use super::motion::Motion;
use crate::experiment::Pressures;

/// Periods within which a pressure changes by a step: a slower change bends the rod and leaves hardly a swing. By as much its
/// clock may be off that of the recording.
const STEP_PERIODS: f64 = 0.5;

/// Times the fastest speed in the period before, from which on the tip moves by a step: a swing that is left decays.
const LEFT: f64 = 1.5;

/// The swings after steps of a pressure, or why there is none.
pub fn cut(
    time: &[f64],
    path: &[Option<[f64; 3]>],
    step: f64,
    sigma: f64,
    pressures: &Pressures,
) -> Result<Vec<Cut>, String> {
    if let Some(why) = cycles::none_moves(path, sigma) {
        return Err(why);
    }
    let (motion, period) = Motion::paced(time, path, step, sigma);
    let within = STEP_PERIODS * period;
    let near = pressures.steps(within);
    let sample = |at: f64| time.partition_point(|t| *t < at);
    let begins: Vec<usize> = near.iter().map(|at| sample(at - within)).collect();
    let ends = begins.iter().skip(1).copied().chain([path.len()]);
    let parts: Vec<Range<usize>> = begins.iter().zip(ends).map(|(begin, end)| *begin..end).collect();
    // The last sample before the pressure changes or the tip moves, whichever is first.
    let rests: Vec<Option<Range<usize>>> = (parts.iter().zip(&near))
        .map(|(part, at)| {
            // What is left of the swing before does not begin this one.
            let before = sample(time[part.start] - period)..part.start;
            let left = before.filter_map(|i| motion.speed(i)).fold(0.0, f64::max);
            let quiet = quiet(&motion, part.clone())?.max(LEFT * left);
            let is_moving = |i: &usize| motion.speed(*i).is_some_and(|speed| speed >= quiet);
            let moves = part.clone().find(is_moving)?;
            let from = (0..moves).rev().find(is_moving).map_or(0, |last| last + 1);
            let last = (from..moves.min(sample(*at))).rev().find(|i| path[*i].is_some())?;
            (moves > part.start).then_some(from..last + 1)
        })
        .collect();
    let cut = |k: usize| {
        let hold = rests[k].clone()?;
        let end =
            rests.get(k + 1).map_or(path.len(), |next| next.as_ref().map_or(parts[k].end, |next| next.end));
        let swing = hold.end..end;
        let held = cycles::mean(path, cycles::late(time, &hold))?;
        let (rest, window) = cycles::rest(time, path, &motion, swing.clone(), held, true)?;
        let turns = cycles::turns(path, swing.clone(), held, rest).len();
        (turns >= LEAST_TURNS).then_some(Cut { hold, swing, held, rest, rest_end: window.end })
    };
    let cuts: Vec<Cut> = (0..near.len()).filter_map(cut).collect();
    if cuts.is_empty() {
        return Err(match near.len() {
            0 => format!("the pressure does not step: it changes by less than a tenth within {within:.2} s"),
            count => format!(
                "the pressure steps {count} time{}, and no swing of a tip at rest begins there",
                if count == 1 { "" } else { "s" }
            ),
        });
    }
    Ok(cuts)
}

/// Speed below which the tip is quiet in a part of a recording, m/s; nothing where noise explains all speeds.
fn quiet(motion: &Motion, part: Range<usize>) -> Option<f64> {
    let fastest = part.filter_map(|i| motion.speed(i)).fold(0.0, f64::max);
    let quiet = cycles::quiet(fastest, motion.noise);
    (FAST * fastest >= 2.0 * quiet).then_some(quiet)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cleaning::distance;
    use crate::cleaning::tests::Noise;

    /// 350 mbar on at 2 s and vented at 9 s, more slowly; the valve's clock is 60 ms late. A swing of 1.3 Hz between two rests.
    #[test]
    fn each_step_of_pressure_begins_a_swing() {
        let time: Vec<f64> = (0..1600).map(|k| 0.01 * f64::from(k)).collect();
        let [on, vent] = [2.0, 9.0];
        let swing = |since: f64| 1.0 - (-0.8 * since.max(0.0)).exp() * (8.0 * since.max(0.0)).cos();
        let height = |t: f64| -0.1 + 0.06 * swing(t - on) - 0.05 * swing(t - vent);
        let mut path: Vec<_> = time.iter().map(|t| Some([0.3, 0.0, height(*t)])).collect();
        Noise::new(3).disturb(&mut path, 1e-4);
        let ramp = |t: f64, from: f64, long: f64| ((t - from) / long).clamp(0.0, 1.0);
        let row = |t: f64| (t + 0.06, 3.5e4 * (ramp(t, on, 0.02) - ramp(t, vent, 0.1)));
        let pressures = Pressures::of(&time.iter().map(|t| row(*t)).collect::<Vec<_>>());
        let cuts = cut(&time, &path, 0.01, 1e-4, &pressures).unwrap();
        assert_eq!(cuts.len(), 2, "{cuts:?}");
        for (cut, [at, held, rest]) in cuts.iter().zip([[on, -0.1, -0.04], [vent, -0.04, -0.09]]) {
            let begin = time[cut.hold.end - 1];
            assert!(begin <= at + 0.011 && begin > at - 0.1, "{begin} s for {at}");
            assert!(distance(cut.held, [0.3, 0.0, held]) < 3e-3, "{cut:?}");
            assert!(distance(cut.rest, [0.3, 0.0, rest]) < 3e-3, "{cut:?}");
        }
        assert!((time[cuts[0].swing.end - 1] - vent).abs() < 0.1);
        // Vented while the swing before has a tenth of its size left.
        let swing = |since: f64| 1.0 - (-0.4 * since.max(0.0)).exp() * (10.0 * since.max(0.0)).cos();
        let left = |t: f64| -0.12 + 0.05 * swing(t - on) - 0.05 * swing(t - vent);
        let mut again: Vec<_> = time.iter().map(|t| Some([0.3, 0.0, left(*t)])).collect();
        Noise::new(3).disturb(&mut again, 2e-5);
        let row = |t: f64| (t, 3.5e4 * (ramp(t, on, 0.01) - ramp(t, vent, 0.01)));
        let own = Pressures::of(&time.iter().map(|t| row(*t)).collect::<Vec<_>>());
        let begins: Vec<f64> =
            cut(&time, &again, 0.01, 2e-5, &own).unwrap().iter().map(|cut| time[cut.hold.end - 1]).collect();
        assert!(
            begins.len() == 2 && begins.iter().zip([on, vent]).all(|(b, at)| (at - b).abs() < 0.05),
            "{begins:?}"
        );
        // A pressure that rises over seconds bends the rod, and is no event; nor is one that stays.
        let slow = Pressures::of(&time.iter().map(|t| (*t, 3.5e4 * ramp(*t, 2.0, 9.0))).collect::<Vec<_>>());
        assert!(cut(&time, &path, 0.01, 1e-4, &slow).unwrap_err().contains("does not step"));
    }
}
