//! Pose of the base: its place and orientation in each frame, and their means.

use nalgebra::{Matrix3, Matrix4, Quaternion, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};

use super::cycles::mean;
use super::points::centroid;
use super::{distance, noise};

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
    /// How far it is from its mean place in each sample, m, where that is taken off the other markers; nothing where
    /// it does not move.
    pub followed: Option<Vec<[f64; 3]>>,
    /// How far it is turned about that place in each sample, as a rotation vector, rad; likewise.
    pub followed_turn: Option<Vec<[f64; 3]>>,
}

/// Standard deviations of its noise by which a base that moves is off its mean.
const MOVES: f64 = 3.0;
/// Share of the distance to the tip by which its motion matters.
const MATTERS: f64 = 1e-3;
/// By how much more than noise a smoothed path may leave of a base that moves.
const LEFT: f64 = 1.15;

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
        followed: None,
        followed_turn: None,
    }
}

/// How a base moves in each sample.
pub(super) struct Moving {
    /// Its place, m.
    place: Path,
    /// Its turns from their mean, as rotation vectors, rad.
    turns: Path,
    /// Errors of place, m, and turn, rad: what its markers move against each other, a base does not.
    errors: [f64; 2],
    /// The line of two markers, about which they show no turn.
    line: Option<Vector3<f64>>,
    /// The same without the marker that moves most: what this marker alone shows is no motion of the base.
    others: Option<Box<Moving>>,
}

impl Moving {
    /// From markers, shape `[markers][samples]`.
    pub fn of_markers(markers: &[Path]) -> Self {
        let others = (markers.len() > 2).then(|| {
            let motion = |path: &Path| {
                of_markers(std::slice::from_ref(path))
                    .map_or(0.0, |pose| pose.deviation.into_iter().fold(0.0, f64::max))
            };
            let most = |a: &usize, b: &usize| motion(&markers[*a]).total_cmp(&motion(&markers[*b]));
            let most = (0..markers.len()).max_by(most);
            let others = (0..markers.len()).filter(|k| Some(*k) != most).map(|k| markers[k].clone());
            Box::new(Self::of_markers(&others.collect::<Vec<_>>()))
        });
        let mean_of = |path: &Path| mean(path, 0..path.len()).map(Vector3::from);
        let line = match markers {
            [a, b] => mean_of(a).zip(mean_of(b)).and_then(|(a, b)| (b - a).try_normalize(0.0)),
            _ => None,
        };
        Self { place: centroid(markers), turns: turns(markers, None), errors: errors(markers), line, others }
    }

    /// From a rigid body.
    pub fn of_body(position: &Path, orientation: &[Option<[f64; 4]>]) -> Self {
        Self {
            place: position.clone(),
            turns: turns(&[], Some(orientation)),
            errors: [0.0; 2],
            line: None,
            others: None,
        }
    }

    /// Whether turns are about the line of two markers for the most part, so that these do not show them.
    fn is_blind_to(&self, turns: &Path) -> bool {
        let along = |line: Vector3<f64>| {
            let square = |turn: &[f64; 3]| {
                let turn = Vector3::from(*turn);
                (turn.dot(&line).powi(2), turn.norm_squared())
            };
            turns.iter().flatten().map(square).fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d))
        };
        self.line.map(along).is_some_and(|(along, whole)| along > 0.5 * whole)
    }

    /// How far the base is off a place, m, and turned, rad, in each sample; nothing where it does not move, or by less than a share
    /// of the distance `far` to the tip that matters.
    fn followed(&self, time: &[f64], step: f64, place: [f64; 3], far: f64) -> [Option<Vec<[f64; 3]>>; 2] {
        let off = |at: [f64; 3]| std::array::from_fn(|k| at[k] - place[k]);
        let off: Path = self.place.iter().map(|at| at.map(off)).collect();
        let [of_place, of_turn] = self.errors;
        let own = [
            followed(time, &off, step, of_place, MATTERS * far),
            followed(time, &self.turns, step, of_turn, MATTERS),
        ];
        let Some(others) = &self.others else { return own };
        let Some(place) = mean(&others.place, 0..others.place.len()) else { return [None, None] };
        let mut shown = others.followed(time, step, place, far);
        if own[1].is_some() && others.is_blind_to(&self.turns) {
            // A turn moves them, however little; a marker that is loose leaves them at rest.
            [shown[1], _] = others.followed(time, step, place, 0.0);
        }
        let mut shown = shown.into_iter();
        own.map(|own| shown.next().flatten().and(own))
    }
}

/// Standard errors of the place of some markers, m, and of their turn, rad, from the pair whose distance changes most. The
/// distance has the errors of two markers, the centroid a share of one.
fn errors(markers: &[Path]) -> [f64; 2] {
    let (mut place, mut turn) = (0.0f64, 0.0f64);
    for (k, a) in markers.iter().enumerate() {
        for b in &markers[..k] {
            let apart = || a.iter().zip(b).filter_map(|(a, b)| Some(distance((*a)?, (*b)?)));
            let mean = apart().sum::<f64>() / apart().count().max(1) as f64;
            let deviation = mean_square(apart().map(|apart| apart - mean)).sqrt();
            place = place.max(deviation / (2.0 * markers.len() as f64).sqrt());
            turn = turn.max(if mean > 0.0 { deviation / mean } else { 0.0 });
        }
    }
    [place, turn]
}

/// Turns of the base in each sample from their mean, as rotation vectors, rad: of a rigid body, of three markers or more, or
/// of two, which show no turn about their own line. Nothing where they are not seen.
fn turns(markers: &[Path], body: Option<&[Option<[f64; 4]>]>) -> Vec<Option<[f64; 3]>> {
    let samples = body.map_or(markers.first().map_or(0, Vec::len), <[_]>::len);
    let points = |i: usize| markers.iter().map(|path| path[i].map(Vector3::from)).collect::<Option<Vec<_>>>();
    let reference = (0..samples).find_map(points);
    let turn = |i: usize| match (body, &reference) {
        (Some(all), _) => {
            all[i].map(|[w, x, y, z]| UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)))
        }
        (None, Some(first)) if first.len() > 2 => kabsch(first, &points(i)?),
        (None, Some(first)) if first.len() == 2 => {
            let now = points(i)?;
            UnitQuaternion::rotation_between(&(first[1] - first[0]), &(now[1] - now[0]))
        }
        _ => None,
    };
    let turns: Vec<Option<UnitQuaternion<f64>>> = (0..samples).map(turn).collect();
    let seen: Vec<_> = turns.iter().flatten().copied().collect();
    let Some(mean) = mean_orientation(&seen) else { return vec![None; samples] };
    turns.into_iter().map(|turn| Some((turn? * mean.inverse()).scaled_axis().into())).collect()
}

impl BasePose {
    /// Follows the base sample by sample, its place and its turns, if they move by more than their noise and by a share of the
    /// distance `far` to the tip that matters.
    pub(super) fn follow(&mut self, time: &[f64], moving: &Moving, step: f64, far: f64) {
        [self.followed, self.followed_turn] = moving.followed(time, step, self.position, far);
        let angles = || moving.turns.iter().flatten().map(|turn| Vector3::from(*turn).norm());
        self.turned = angles().fold(0.0, f64::max);
        self.turn_deviation = mean_square(angles()).sqrt();
    }

    /// Takes the motion of the base off a path.
    pub(super) fn take_off(&self, path: &mut Path) {
        let place = Vector3::from(self.position);
        for (i, at) in path.iter_mut().enumerate() {
            let of = |all: &Option<Vec<[f64; 3]>>| all.as_ref().map_or(Vector3::zeros(), |all| all[i].into());
            let (off, turn) = (of(&self.followed), UnitQuaternion::new(of(&self.followed_turn)));
            *at = at.map(|at| (place + turn.inverse() * (Vector3::from(at) - off - place)).into());
        }
    }

    /// Whether its motion is taken off other markers.
    pub fn is_followed(&self) -> bool {
        self.followed.is_some() || self.followed_turn.is_some()
    }
}

/// What moves about zero, in each sample, if it moves by more than its noise, or a standard error that is larger, and than what
/// matters: smoothed as far as its noise alone is left over, and on a straight line where it is lost.
fn followed(time: &[f64], off: &Path, step: f64, error: f64, matters: f64) -> Option<Vec<[f64; 3]>> {
    let seen: Vec<usize> = (0..off.len()).filter(|i| off[*i].is_some()).collect();
    let sigma = noise::of_path(time, off, step).unwrap_or(0.0).max(error);
    let along = |k: usize| mean_square(seen.iter().filter_map(|i| Some(off[*i]?[k]))).sqrt();
    if (0..3).map(along).fold(0.0, f64::max) <= (MOVES * sigma).max(matters) {
        return None;
    }
    let whole: Vec<[f64; 3]> = (0..off.len())
        .map(|i| {
            let next = seen.partition_point(|k| *k < i);
            let (before, after) = (seen[next.saturating_sub(1)], seen[next.min(seen.len() - 1)]);
            let share =
                if after > before { (time[i] - time[before]) / (time[after] - time[before]) } else { 0.0 };
            let [a, b]: [[f64; 3]; 2] = [before, after].map(|k| off[k].expect("it is seen"));
            std::array::from_fn(|k| a[k] + share.clamp(0.0, 1.0) * (b[k] - a[k]))
        })
        .collect();
    let mut best = whole.clone();
    for half in (0..).map(|k| 1 << k).take_while(|half| 4 * half < whole.len()) {
        let smooth = running_means(&whole, half);
        let left = seen.iter().flat_map(|i| (0..3).map(|k| (whole[*i][k] - smooth[*i][k]).powi(2)));
        let left = (left.sum::<f64>() / (3 * seen.len()) as f64).sqrt();
        if left > LEFT * sigma {
            break;
        }
        best = smooth;
    }
    Some(best)
}

/// Means over so many samples to either side; fewer at the ends, as many on both sides.
fn running_means(path: &[[f64; 3]], half: usize) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]];
    for at in path {
        let last = sums[sums.len() - 1];
        sums.push(std::array::from_fn(|k| last[k] + at[k]));
    }
    let mean = |i: usize| {
        let half = half.min(i).min(path.len() - 1 - i);
        let (from, to) = (i - half, i + half + 1);
        std::array::from_fn(|k| (sums[to][k] - sums[from][k]) / (to - from) as f64)
    };
    (0..path.len()).map(mean).collect()
}

/// Mean square about a mean that is known from the same values; zero of one value.
fn mean_square(off: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = off.fold((0.0, 0usize), |(sum, count), off| (sum + off * off, count + 1));
    sum / count.saturating_sub(1).max(1) as f64
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
mod tests;
