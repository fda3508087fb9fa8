//! Pose of the base: its place and orientation in each frame, and their means.

use nalgebra::{Matrix3, Matrix4, Quaternion, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};

/// Mean pose of the base over a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct BasePose {
    /// Mean position, m, in the recording's frame.
    pub position: [f64; 3],
    /// Mean orientation `[w, x, y, z]`: of a rigid body its own, of markers the turn from the first frame
    /// that shows all of them; nothing with fewer than three markers.
    pub orientation: Option<[f64; 4]>,
    /// Farthest that a frame's position is from the mean, m.
    pub moved: f64,
    /// Farthest that a frame's orientation is turned from the mean, rad.
    pub turned: f64,
    /// Standard deviation of its position along each axis of the recording, m.
    pub deviation: [f64; 3],
    /// Root mean square of the angles by which its frames are turned from the mean, rad.
    pub turn_deviation: f64,
    /// Frames that show it.
    pub frames: usize,
}

type Path = Vec<Option<[f64; 3]>>;

/// From markers, shape `[markers][samples]`; frames in which one is lost are left out.
pub fn of_markers(markers: &[Path]) -> Option<BasePose> {
    let samples = markers.first()?.len();
    let frames: Vec<Vec<Vector3<f64>>> = (0..samples)
        .filter_map(|i| markers.iter().map(|path| path[i].map(Vector3::from)).collect::<Option<Vec<_>>>())
        .collect();
    let reference = frames.first()?;
    let center = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let positions: Vec<_> = frames.iter().map(|frame| center(frame)).collect();
    let turns: Vec<_> = match markers.len() {
        0..=2 => Vec::new(),
        _ => frames.iter().filter_map(|frame| kabsch(reference, frame)).collect(),
    };
    Some(pose(&positions, &turns))
}

/// From a rigid body.
pub fn of_body(position: &Path, orientation: &[Option<[f64; 4]>]) -> Option<BasePose> {
    let seen: Vec<_> = position.iter().zip(orientation).filter_map(|(p, q)| Some(((*p)?, (*q)?))).collect();
    let positions: Vec<_> = seen.iter().map(|(position, _)| Vector3::from(*position)).collect();
    let turn = |[w, x, y, z]: [f64; 4]| UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let turns: Vec<_> = seen.iter().map(|(_, q)| turn(*q)).collect();
    (!positions.is_empty()).then(|| pose(&positions, &turns))
}

fn pose(positions: &[Vector3<f64>], turns: &[UnitQuaternion<f64>]) -> BasePose {
    let mean = positions.iter().sum::<Vector3<f64>>() / positions.len() as f64;
    let orientation = mean_orientation(turns);
    let turned =
        |mean: &UnitQuaternion<f64>| turns.iter().map(|turn| turn.angle_to(mean)).fold(0.0, f64::max);
    BasePose {
        position: mean.into(),
        orientation: orientation.map(|q| [q.w, q.i, q.j, q.k]),
        moved: positions.iter().map(|position| (position - mean).norm()).fold(0.0, f64::max),
        turned: orientation.as_ref().map_or(0.0, turned),
        deviation: std::array::from_fn(|k| {
            mean_square(positions.iter().map(|position| position[k] - mean[k])).sqrt()
        }),
        turn_deviation: orientation
            .map_or(0.0, |mean| mean_square(turns.iter().map(|turn| turn.angle_to(&mean))).sqrt()),
        frames: positions.len(),
    }
}

/// Mean square about a mean that is known from the same values; zero of one value.
fn mean_square(off: impl ExactSizeIterator<Item = f64>) -> f64 {
    let degrees = off.len().saturating_sub(1).max(1) as f64;
    off.map(|off| off * off).sum::<f64>() / degrees
}

/// The turn that takes points of the reference onto others; none of points on one line.
///
/// Source: Kabsch (1976), A solution for the best rotation to relate two sets of vectors, by the
/// singular value decomposition.
pub fn kabsch(reference: &[Vector3<f64>], points: &[Vector3<f64>]) -> Option<UnitQuaternion<f64>> {
    let center = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let (from, to) = (center(reference), center(points));
    let pairs = reference.iter().zip(points);
    let covariance: Matrix3<f64> = pairs.map(|(a, b)| (b - to) * (a - from).transpose()).sum();
    let svd = covariance.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    // Two of the three must differ from zero for the turn to be known.
    if svd.singular_values[1] <= 1e-9 * svd.singular_values[0] {
        return None;
    }
    // Mirror images are no turns.
    let sign = (u * v_t).determinant().signum();
    let turn = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v_t;
    Some(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn)))
}

/// The unit quaternion that is nearest to all: `q` and `−q` are the same turn.
///
/// Source: Markley, Cheng, Crassidis and Oshman (2007), Averaging quaternions.
pub fn mean_orientation(turns: &[UnitQuaternion<f64>]) -> Option<UnitQuaternion<f64>> {
    if turns.is_empty() {
        return None;
    }
    let outer: Matrix4<f64> = turns.iter().map(|q| q.coords * q.coords.transpose()).sum();
    let eigen = SymmetricEigen::new(outer);
    let vector = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
    let sign = if vector[3] < 0.0 { -1.0 } else { 1.0 };
    Some(UnitQuaternion::from_quaternion(Quaternion::from_vector(sign * vector)))
}

#[cfg(test)]
mod tests {
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
}
