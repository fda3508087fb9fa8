//! The pictures of an experiment's page: what was cut and masked, each release's swing, spectrum and damping,
//! and what the releases say together: stiffness by method, tip error by nodes, frequency and damping over
//! pressure.

use std::f64::consts::TAU;

use efam_experiments::analyse::Analysed;
use efam_experiments::analysis::AnalysisError;
use efam_experiments::analysis::bending_stiffness::StiffnessFit;
use efam_experiments::analysis::static_stiffness::StaticFit;
use efam_experiments::cleaning::Cleaned;

use crate::picture::lines::{Lines, MOST_LINES, Named, spread};
use crate::picture::measured::{damping, frequencies, swing};
use crate::picture::recording::recording;
use crate::picture::released::SIZE;
use crate::picture::{MILLI, Picture, drawn, model_name};

const KILO: f64 = 1e3;

/// What was cut and masked, a picture each recording.
pub fn recordings(cleaned: &Cleaned) -> Vec<Picture> {
    let picture = |(k, of): (usize, &efam_experiments::cleaning::CleanRecording)| {
        let releases: Vec<_> = cleaned.releases.iter().filter(|release| release.recording == k).collect();
        Picture {
            name: format!("recording-{:02}", k + 1),
            title: format!("Recording {}", of.name),
            caption: "The tip over time, with masked samples and the cut of each release; its path in the plane of the swing; its distance from that plane.".to_owned(),
            drawing: recording(of, &releases),
        }
    };
    cleaned.recordings.iter().enumerate().map(picture).collect()
}

/// What the analysis found, over all releases and of each.
pub fn analysed(all: &[Analysed]) -> Vec<Picture> {
    let mut pictures = over_pressure(all);
    pictures.extend(over_nodes(all));
    for (k, one) in all.iter().enumerate() {
        let Ok(measured) = &one.measured else { continue };
        let name = &one.of.release.name;
        pictures.push(Picture {
            name: format!("release-{:02}-swing", k + 1),
            title: format!("Swing and spectrum: {name}"),
            caption: "The coordinate that was analysed, with its upper peaks and eq. 6 fitted to them; its amplitude spectrum.".to_owned(),
            drawing: drawn((760, 760), |page| {
                let (above, below) = page.split_vertically(page.dim_in_pixel().1 / 2);
                swing(measured, &above)?;
                frequencies(measured, &below)
            }),
        });
        pictures.push(Picture {
            name: format!("release-{:02}-damping", k + 1),
            title: format!("Damping over amplitude: {name}"),
            caption: "From each upper peak to the next. A linear loss would be level.".to_owned(),
            drawing: drawn(SIZE, |page| damping(measured, page)),
        });
    }
    pictures
}

/// The better search of the two: both minimise the same.
pub(super) fn found(of: &StaticFit) -> Result<&StiffnessFit, &AnalysisError> {
    of.gauss_newton.as_ref().or(of.nelder_mead.as_ref())
}

fn over_pressure(all: &[Analysed]) -> Vec<Picture> {
    let at = |one: &Analysed| Some(one.of.release.pressure? / KILO);
    let points = |value: &dyn Fn(&Analysed) -> Option<f64>| -> Vec<(f64, f64)> {
        let mut points: Vec<(f64, f64)> =
            all.iter().filter_map(|one| Some((at(one)?, value(one)?))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    if points(&|_| Some(0.0)).is_empty() {
        return Vec::new();
    }
    let picture = |name: &str, title: &str, caption: &str, label: &str, lines: Vec<Named>| {
        let from_zero = name != "frequency";
        let of = Lines {
            title,
            x: "pressure, kPa",
            y: label,
            marks: true,
            from_zero,
            why: "no release at a stated pressure has it",
        };
        Picture {
            name: name.to_owned(),
            title: title.to_owned(),
            caption: caption.to_owned(),
            drawing: drawn(SIZE, |page| of.draw(page, &lines)),
        }
    };
    let decay = |of: fn(&efam_experiments::analysis::decay::Decay) -> f64| {
        points(&|one: &Analysed| one.measured.as_ref().ok()?.decay.as_ref().ok().map(of))
    };
    let cycles = points(&|one: &Analysed| {
        let cycles = one.measured.as_ref().ok()?.cycles.as_ref().ok()?;
        cycles.last().map(|cycle| cycle.damping_ratio)
    });
    let damped =
        points(&|one: &Analysed| Some(one.measured.as_ref().ok()?.damped_frequency.as_ref().ok()? / TAU));
    let mut pictures = vec![
        picture(
            "frequency",
            "Frequency over pressure",
            "Damped, from the spectrum, and natural by eq. 7.",
            "frequency, Hz",
            vec![
                ("damped, spectrum".to_owned(), damped),
                ("natural, eq. 7".to_owned(), decay(|decay| decay.natural_frequency / TAU)),
            ],
        ),
        picture(
            "damping",
            "Damping ratio over pressure",
            "By eq. 6 from all upper peaks, and from the last two, which are the smallest.",
            "damping ratio, dimensionless",
            vec![
                ("eq. 6, all peaks".to_owned(), decay(|decay| decay.damping_ratio)),
                ("last cycle".to_owned(), cycles),
            ],
        ),
    ];
    let mut lines: Vec<Named> = Vec::new();
    // The beam first; a release with an inclined base has none.
    let mut models: Vec<Option<usize>> =
        all.iter().flat_map(|one| one.at_rest.iter().map(|fit| fit.nodes)).collect();
    models.sort_unstable();
    models.dedup();
    for nodes in models {
        let fit = |one: &Analysed| one.at_rest.iter().position(|fit| fit.nodes == nodes);
        let ei = |one: &Analysed| Some(found(&one.at_rest[fit(one)?]).ok()?.bending_stiffness);
        lines.push((model_name(nodes), points(&ei)));
    }
    lines.truncate(MOST_LINES - 1);
    let motion = |one: &Analysed| Some(one.in_motion.as_ref()?.as_ref().ok()?.bending_stiffness);
    lines.push(("from the frequency".to_owned(), points(&motion)));
    if lines.iter().any(|line| !line.1.is_empty()) {
        pictures.push(picture(
            "stiffness",
            "Bending stiffness over pressure, by method",
            "EI from the tip at rest by the Euler-Bernoulli beam and by the discrete rod, and from the frequency by the model's own swing. An EI belongs to its model, mesh and root.",
            "EI, N m²",
            lines,
        ));
    }
    pictures
}

/// How far the tip at rest is missed with the best EI, over the number of nodes.
fn over_nodes(all: &[Analysed]) -> Option<Picture> {
    let points = |one: &Analysed| -> Named {
        let row = |of: &StaticFit| {
            let [x, z] = found(of).ok()?.residual;
            Some((of.nodes? as f64, MILLI * x.hypot(z)))
        };
        (one.of.release.name.clone(), one.at_rest.iter().filter_map(row).collect())
    };
    let lines: Vec<Named> = all.iter().map(points).filter(|line| line.1.len() > 1).collect();
    if lines.is_empty() {
        return None;
    }
    let of = Lines {
        title: "Tip error over the number of nodes",
        x: "nodes of the discrete rod",
        y: "tip error, mm",
        marks: true,
        from_zero: true,
        why: "no model",
    };
    Some(Picture {
        name: "tip-error".to_owned(),
        title: of.title.to_owned(),
        caption: "Distance of the measured tip at rest from that of the discrete rod with the EI that comes nearest.".to_owned(),
        drawing: drawn(SIZE, |page| of.draw(page, &spread(&lines, MOST_LINES))),
    })
}
