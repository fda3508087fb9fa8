use super::*;

#[test]
fn a_turned_and_moved_base_is_found_again() {
    let shape = [[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.0, 0.03, 0.0], [0.01, 0.01, 0.04]];
    let turn = |degrees: f64| UnitQuaternion::from_euler_angles(degrees.to_radians(), 0.0, 0.0);
    let degrees = [0.0, 2.0, 4.0];
    let markers: Vec<Path> = shape
        .iter()
        .map(|point| {
            let at = |degrees: f64| {
                let p = turn(degrees) * Vector3::from(*point) + Vector3::new(1.0, 2.0, 3.0);
                Some(p.into())
            };
            degrees.iter().map(|d| at(*d)).collect()
        })
        .collect();
    let pose = of_markers(&markers).unwrap();
    let [w, x, y, z] = pose.orientation.unwrap();
    // The mean of turns about one axis by 0, 2 and 4 degrees turns by 2.
    assert!((2.0 * x.atan2(w) - 2f64.to_radians()).abs() < 1e-9 && y.abs() + z.abs() < 1e-9);
    assert!((pose.turned - 2f64.to_radians()).abs() < 1e-9, "{pose:?}");
    // Of 2, 0 and 2 degrees with two degrees of freedom.
    assert!((pose.turn_deviation - 2f64.to_radians()).abs() < 1e-9, "{pose:?}");
    let two = of_markers(&markers[..2]).unwrap();
    assert_eq!((two.orientation, two.frames), (None, 3));
}

/// A base that drifts by 30 mm is followed to its noise over the smoothing; one at rest is not.
#[test]
fn a_base_that_moves_is_followed_and_one_at_rest_is_not() {
    let mut noise = crate::cleaning::tests::Noise::new(5);
    let time: Vec<f64> = (0..400).map(|i| 0.02 * f64::from(i)).collect();
    let drift = |t: f64| 0.015 * (0.8 * t).sin();
    for (share, is_followed) in [(1.0, true), (0.0, false)] {
        let mut path: Path = time.iter().map(|t| Some([0.1, 0.0, share * drift(*t)])).collect();
        noise.disturb(&mut path, 1e-4);
        path[100..110].fill(None);
        let mut pose = of_markers(std::slice::from_ref(&path)).unwrap();
        pose.follow(&time, &Moving::of_markers(std::slice::from_ref(&path)), 0.02, 0.4);
        assert_eq!(pose.followed.is_some(), is_followed);
        for (t, off) in time.iter().zip(pose.followed.iter().flatten()) {
            // Over three samples at least, noise is less by 1.7; three standard deviations.
            assert!((off[2] + pose.position[2] - drift(*t)).abs() < 2.5e-4, "{off:?} at {t}");
        }
    }
}

/// Three markers at rest, of which one is seen 0.1 mm off for a while: it moves against the others, so the base does not turn.
#[test]
fn a_marker_that_moves_against_the_others_is_no_turn() {
    let mut noise = crate::cleaning::tests::Noise::new(7);
    let time: Vec<f64> = (0..400).map(|i| 0.02 * f64::from(i)).collect();
    let mut markers = [[0.0, 0.0, 0.0], [0.058, 0.0, 0.0], [0.05, 0.0, 0.027]]
        .map(|at| time.iter().map(|_| Some(at)).collect::<Path>());
    markers.iter_mut().for_each(|path| noise.disturb(path, 1e-5));
    // In the plane of the markers it changes distances; across it does not.
    for axis in 0..3 {
        let mut seen = markers.clone();
        for (t, at) in time.iter().zip(seen[2].iter_mut().flatten()) {
            at[axis] += 3e-4 * (0.9 * t).sin();
        }
        let mut pose = of_markers(&seen).unwrap();
        pose.follow(&time, &Moving::of_markers(&seen), 0.02, 0.1);
        assert!(!pose.is_followed() && pose.turn_deviation > 1e-3, "{axis}: {pose:?}");
    }
}

/// A base that turns by up to 3 degrees and drifts, of two markers, of three and of a body: a point that is fixed to it is
/// at rest when its motion is taken off, though it is 0.4 m from it.
#[test]
fn a_base_that_turns_is_followed() {
    let time: Vec<f64> = (0..400).map(|i| 0.02 * f64::from(i)).collect();
    let turn = |t: f64| UnitQuaternion::from_euler_angles(0.0, 0.05 * (0.7 * t).sin(), 0.0);
    let moved = |at: [f64; 3]| -> Path {
        let drift = |t: f64| Vector3::new(0.1, 0.0, 0.004 * (0.4 * t).sin());
        time.iter().map(|t| Some((turn(*t) * Vector3::from(at) + drift(*t)).into())).collect()
    };
    let mut noise = crate::cleaning::tests::Noise::new(6);
    let mut markers = [[-0.05, 0.0, 0.0], [0.05, 0.0, 0.0], [0.0, 0.0, 0.08]].map(moved);
    markers.iter_mut().for_each(|path| noise.disturb(path, 5e-5));
    let orientation: Vec<_> = time.iter().map(|t| Some(turn(*t)).map(|q| [q.w, q.i, q.j, q.k])).collect();
    for (count, body) in [(2, None), (3, None), (1, Some(&orientation[..]))] {
        let own = &markers[..count];
        let mut pose = of_markers(own).unwrap();
        let moving = body.map_or_else(|| Moving::of_markers(own), |body| Moving::of_body(&own[0], body));
        pose.follow(&time, &moving, 0.02, 0.4);
        assert!((pose.turned - 0.05).abs() < 0.015, "{count}: {}", pose.turned);
        let mut fixed = moved([0.4, 0.0, 0.0]);
        pose.take_off(&mut fixed);
        let mean = crate::cleaning::cycles::mean(&fixed, 0..400).unwrap();
        let off = |at: &[f64; 3]| crate::cleaning::distance(*at, mean);
        let farthest = fixed.iter().flatten().map(off).fold(0.0, f64::max);
        // Of 20 mm; a marker's noise on an arm of 0.05 m, over the smoothing, is 0.2 mm at 0.4 m.
        assert!(farthest < 1e-3, "{count} markers: {farthest} m");
    }
}

/// Two of three markers lie along the axis of the turn, 30 mm from it, and show no turn by themselves.
#[test]
fn a_turn_about_the_line_of_two_markers_is_followed() {
    let time: Vec<f64> = (0..800).map(|i| 0.01 * f64::from(i)).collect();
    let turn = |t: f64| UnitQuaternion::from_euler_angles(0.0, 0.03 * t / 8.0, 0.0);
    let moved =
        |at: [f64; 3]| -> Path { time.iter().map(|t| Some((turn(*t) * Vector3::from(at)).into())).collect() };
    let mut noise = crate::cleaning::tests::Noise::new(8);
    let mut markers = [[-0.03, 0.02, 0.01], [-0.03, -0.02, 0.01], [-0.06, 0.0, 0.01]].map(moved);
    markers.iter_mut().for_each(|path| noise.disturb(path, 5e-5));
    let mut pose = of_markers(&markers).unwrap();
    pose.follow(&time, &Moving::of_markers(&markers), 0.01, 0.45);
    let mut fixed = moved([0.4, 0.0, 0.0]);
    pose.take_off(&mut fixed);
    let mean = crate::cleaning::cycles::mean(&fixed, 0..800).unwrap();
    let off = fixed.iter().flatten().map(|at| crate::cleaning::distance(*at, mean));
    let off = mean_square(off).sqrt();
    // Of 3.5 mm. Its place moves by 0.4 mm, which is too little to be taken off.
    assert!(off < 6e-4, "{off} m");
}

#[test]
fn a_mirror_image_is_no_turn_and_a_line_has_none() {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from);
    let mirrored = points.map(|p| Vector3::new(p.x, p.y, -p.z));
    let turn = kabsch(&points, &mirrored).unwrap();
    assert!((turn.to_rotation_matrix().matrix().determinant() - 1.0).abs() < 1e-9);
    let line = [0.0, 1.0, 2.0].map(|x| Vector3::new(x, 0.0, 0.0));
    assert!(kabsch(&line, &line).is_none());
}

#[test]
fn a_body_and_its_opposite_quaternion_are_the_same() {
    let q = [0.6f64.sqrt(), 0.4f64.sqrt(), 0.0, 0.0];
    let position = vec![Some([1.0, 0.0, 0.0]), None, Some([1.002, 0.0, 0.0])];
    let pose = of_body(&position, &[Some(q), Some(q), Some(q.map(|x| -x))]).unwrap();
    assert!((pose.moved - 1e-3).abs() < 1e-12 && pose.turned < 1e-6, "{pose:?}");
    assert!((pose.orientation.unwrap()[0] - q[0]).abs() < 1e-9);
    // Two places, 2 mm apart: a millimetre off the mean each, with one degree of freedom.
    let [x, y, z] = pose.deviation;
    assert!((x - 2f64.sqrt() * 1e-3).abs() < 1e-12 && y + z + pose.turn_deviation < 1e-6, "{pose:?}");
}
