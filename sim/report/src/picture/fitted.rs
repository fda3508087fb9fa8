//! The pictures of a calibration's page: each track with its residuals, its decay and damping, the parameters
//! over pressure, what cannot be separated.

use efam_inference::calibrate::misfit::swing_of;
use efam_inference::calibrate::{Calibration, Curve};

use crate::picture::calibrated::{damping, decay, one_parameter, overlay, paths_over_pressure, residuals};
use crate::picture::matrix::correlations;
use crate::picture::{Picture, drawn};

/// All pictures of a calibration, in the order in which one would look at them.
pub fn fitted(calibration: &Calibration, curves: &[Curve]) -> Vec<Picture> {
    let mut pictures = Vec::new();
    for path in paths_over_pressure(calibration) {
        pictures.push(Picture {
            name: format!("parameter-{}", path.replace('.', "-")),
            title: path.clone(),
            caption:
                "Its value at each pressure, with the interval that holds the truth in 95 % of experiments."
                    .to_owned(),
            drawing: drawn((760, 480), |page| one_parameter(&path, &calibration.of(&path), page)),
        });
    }
    let groups = calibration.correlations.iter().enumerate();
    pictures.extend(groups.filter_map(|(k, group)| correlations(k + 1, group)));
    for (k, curve) in curves.iter().enumerate() {
        let of = format!("{}, {}", curve.release, curve.marker);
        pictures.push(Picture {
            name: format!("fit-{:02}-path", k + 1),
            title: format!("Fit and residual: {of}"),
            caption: "Height as measured and as fitted; below, what is left of both coordinates.".to_owned(),
            drawing: drawn((760, 760), |page| {
                let (above, below) = page.split_vertically(page.dim_in_pixel().1 / 2);
                overlay(curve, &above)?;
                residuals(curve, &below)
            }),
        });
        let both = [swing_of(curve, &curve.measured), swing_of(curve, &curve.predicted)];
        pictures.push(Picture {
            name: format!("fit-{:02}-decay", k + 1),
            title: format!("Decay and damping: {of}"),
            caption: "Upper peaks over time, and the damping ratio from each to the next over its amplitude."
                .to_owned(),
            drawing: drawn((760, 760), |page| {
                let (above, below) = page.split_vertically(page.dim_in_pixel().1 / 2);
                decay(&both, &above)?;
                damping(&both, &below)
            }),
        });
    }
    pictures
}
