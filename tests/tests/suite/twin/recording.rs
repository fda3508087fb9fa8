//! Goal: a twin's recording has what issue 3 requires: rate, losses in bursts, ghosts, six cycles,
//! releases between samples; and one seed gives one recording.

use efam_recordings::Recording;
use tests::twin::direct::Direct;
use tests::twin::muscle;
use tests::twin::random::Random;
use tests::twin::sensor::Cameras;
use tests::twin::session::{Session, six_cycles};
use tests::twin::text;

const TIP: f64 = 0.0168;

fn session(seed: u64) -> Session {
    let beam = muscle(15.0, 6, 2.0, 0.02);
    Session::play(&beam, &six_cycles(&mut Random::new(seed), 6.0, 0.0), 5e-3)
}

fn recording(session: &Session, cameras: &Cameras) -> Recording {
    cameras.record(session, &mut Random::new(7))
}

fn quiet(length: f64) -> Cameras {
    let usual = Cameras::usual(0.0, length, TIP, &[0.5]);
    Cameras { lost: 0.0, ghosts: 0.0, drift: 0.0, out_of_plane: 0.0, yaw: 0.0, clamp: [0.0; 3], ..usual }
}

#[test]
fn losses_ghosts_and_noise_come_to_their_share() {
    let session = session(1);
    let usual = Cameras::usual(0.3e-3, session.beam.length, TIP, &[0.5]);
    let clean = recording(&session, &Cameras { noise: 0.0, lost: 0.0, ghosts: 0.0, ..usual.clone() });
    let seen = recording(&session, &usual);
    let [mut count, mut lost, mut bursts, mut ghosts, mut square, mut good] = [0.0_f64; 6];
    for (clean, seen) in clean.markers.iter().zip(&seen.markers) {
        for (k, (clean, at)) in clean.position.iter().zip(&seen.position).enumerate() {
            count += 1.0;
            let Some(at) = at else {
                lost += 1.0;
                bursts += f64::from(k == 0 || seen.position[k - 1].is_some());
                continue;
            };
            let off: f64 = at.iter().zip(clean.expect("all seen")).map(|(a, c)| (a - c).powi(2)).sum();
            if off.sqrt() > 2e-3 { ghosts += 1.0 } else { (square, good) = (square + off, good + 3.0) }
        }
    }
    // Some 45 000 samples: 180 bursts, 140 ghosts; four standard deviations of those counts.
    assert!((lost / count - 0.03).abs() < 0.01, "lost {}", lost / count);
    assert!((lost / bursts - usual.burst).abs() < 1.5, "bursts of {}", lost / bursts);
    assert!((ghosts / count - 0.003).abs() < 0.001, "ghosts {}", ghosts / count);
    assert!(((square / good).sqrt() / usual.noise - 1.0).abs() < 0.02, "noise {}", (square / good).sqrt());
}

/// The tip's path over a recording: level in the hand up to the release, falling after it.
#[test]
fn six_times_it_is_held_level_and_let_go() {
    let session = session(2);
    let recording = recording(&session, &quiet(session.beam.length));
    assert_eq!(session.releases.len(), 6);
    let height = |time: f64| {
        let k = (time * recording.rate_hz) as usize;
        let tips = recording.markers.iter().filter(|m| m.name.starts_with("tip"));
        tips.map(|m| m.position[k].expect("all seen")[2] / 3.0).sum::<f64>()
    };
    for release in &session.releases {
        assert!((release * 100.0).fract() > 1e-6, "{release} s falls on a sample");
        assert!(height(release - 0.01).abs() < 0.2e-3, "level before {release} s");
        assert!(height(release + 0.11) < -0.02, "falls after {release} s");
        assert!(height(release - 4.5) < -0.1, "hangs before the raise to {release} s");
    }
    // A hand takes it along: no jump between hanging, hand and swing.
    let steps = recording.markers.iter().flat_map(|m| m.position.windows(2));
    let farthest =
        steps.map(|w| (0..3).map(|k| (w[1].unwrap()[k] - w[0].unwrap()[k]).powi(2)).sum::<f64>().sqrt());
    assert!(farthest.fold(0.0, f64::max) < 0.05, "never faster than 5 m/s");
}

#[test]
fn the_frame_is_turned_and_shifted_but_nothing_else() {
    let session = session(2);
    let quiet = quiet(session.beam.length);
    let plain = recording(&session, &quiet);
    for up in 0..3 {
        let moved = recording(&session, &Cameras { up, yaw: 0.7, clamp: [1.0, 2.0, 3.0], ..quiet.clone() });
        let vertical = |r: &Recording, axis: usize| r.markers[5].position[1000].expect("seen")[axis];
        assert!((vertical(&moved, up) - [1.0, 2.0, 3.0][up] - vertical(&plain, 2)).abs() < 1e-12);
        let distance = |r: &Recording| {
            let [a, b] = [0, 5].map(|m| r.markers[m].position[1000].expect("seen"));
            (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
        };
        assert!((distance(&moved) - distance(&plain)).abs() < 1e-12);
    }
}

#[test]
fn one_seed_gives_one_recording_and_its_text_one_line_a_sample() {
    let session = session(3);
    let usual = Cameras::usual(0.3e-3, session.beam.length, TIP, &[]);
    let [a, b] = [recording(&session, &usual), recording(&session, &usual)];
    assert_eq!(a, b);
    let text = text::tidy(&a);
    assert_eq!(text.lines().count(), a.time.len() + 1);
    assert!(text.starts_with("t_s,base_1_x_m,base_1_y_m,base_1_z_m,base_2_x_m"), "{}", &text[..60]);
    let columns = |line: &str| line.split(',').count();
    assert!(text.lines().all(|line| columns(line) == 1 + 3 * a.markers.len()));
}

/// What is seen directly is the true path, at times that are off by what the instant is off.
#[test]
fn releases_carry_times_after_an_estimate_of_the_instant() {
    let session = session(4);
    let direct = Direct { noise: 0.0, lost: 0.0, instant: 2e-3, offset: 0.0, ..Direct::usual(0.0, 6.0, TIP) };
    let releases = direct.see(&session, &mut Random::new(5));
    assert_eq!(releases.len(), 6);
    let share = 1.0 + TIP / session.beam.length;
    for release in releases {
        // The shift of time for which the true path is the seen one.
        let off = |late: f64| -> f64 {
            let times: Vec<f64> = release.time.iter().map(|t| t + late).collect();
            let path = session.motion(0).path(&session.beam, share, &times);
            let seen = release.tracks[0].position.iter().map(|x| x.expect("none is lost"));
            path[20..].iter().zip(seen.skip(20)).map(|(a, b)| (a[1] - b[1]).powi(2)).sum()
        };
        let late = (-100..=100).map(|k| k as f64 * 1e-4).min_by(|a, b| off(*a).total_cmp(&off(*b)));
        assert!(late.expect("some").abs() < 4.0 * direct.instant, "{late:?}");
        assert!(release.time[0] > -0.008 && release.time[0] < 0.018);
    }
}
