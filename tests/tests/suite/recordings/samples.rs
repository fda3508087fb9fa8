//! Goal: what motion-capture systems really export is read rightly.
//! Setup: recordings that others made, beside the project; where they are absent a test says so and
//! checks nothing.
//! Expected: rates, units, markers and lost points as their descriptions state.

use std::path::{Path, PathBuf};

use efam_recordings::{Format, ReadOptions, Recording, read};
use tests::recordings::says;
use tests::skipped;

/// The file, if the recordings are there.
fn sample(file: &str) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = root.join("../shared/recordings");
    if !folder.is_dir() {
        skipped("recordings", "there are none in ../shared/recordings");
        return None;
    }
    let path = folder.join(file);
    assert!(path.exists(), "{} is not there, and its folder is", path.display());
    Some(path)
}

fn load(file: &str) -> Option<Recording> {
    let path = sample(file)?;
    Some(read(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}")))
}

fn lost(recording: &Recording) -> usize {
    recording.markers.iter().map(|marker| marker.quality().lost).sum()
}

fn is(recording: &Recording, format: Format, rate_hz: f64, samples: usize, markers: usize) {
    assert_eq!(recording.format, format);
    assert_eq!(recording.rate_hz, rate_hz);
    assert_eq!(recording.time.len(), samples);
    assert_eq!(
        recording.markers.len(),
        markers,
        "{:?}",
        recording.markers.iter().map(|m| &m.name).collect::<Vec<_>>()
    );
    assert!(recording.markers.iter().all(|marker| marker.position.len() == samples));
}

#[test]
fn four_encodings_of_one_trial_agree() {
    let files = ["pi", "pr", "vr", "sr"].map(|kind| load(&format!("formats/c3d_btk__Eb015{kind}.c3d")));
    let [Some(integers), Some(intel), Some(dec), Some(mips)] = files else { return };
    for recording in [&integers, &intel, &dec, &mips] {
        is(recording, Format::C3d, 50.0, 450, 26);
        assert_eq!(lost(recording), 226);
        says(recording, "unit: mm, as POINT:UNITS states");
        assert_eq!(recording.markers[0].name, "RFT1");
    }
    assert_eq!(intel.markers, mips.markers);
    for other in [&dec, &integers] {
        for (a, b) in intel.markers.iter().zip(&other.markers) {
            assert_eq!(a.name, b.name);
            for (a, b) in a.position.iter().zip(&b.position) {
                assert_eq!(a.is_some(), b.is_some());
                let pairs = a.iter().flatten().zip(b.iter().flatten());
                // Single precision of coordinates up to 3 m.
                pairs.for_each(|(a, b)| assert!((a - b).abs() <= 3.0 * f64::from(f32::EPSILON), "{a} {b}"));
            }
        }
    }
}

#[test]
fn optitrack_c3d_is_valid_by_its_residuals() {
    let Some(recording) = load("formats/c3d_optitrack__ktk_walkingOptiTrack.c3d") else { return };
    is(&recording, Format::C3d, 160.0, 3361, 12);
    says(&recording, "frame 0 is time 0");
    assert_eq!(lost(&recording), 2996);
    // Lost points have coordinates, too, with x from -755 to 1514 mm; those that were seen end at 931 mm.
    let seen = recording.markers.iter().flat_map(|marker| marker.position.iter().flatten());
    let farthest = seen.map(|position| position[0]).fold(0.0, f64::max);
    assert!((0.930..0.932).contains(&farthest), "{farthest}");
}

#[test]
fn nexus_resaved_by_a_spreadsheet() {
    let Some(recording) = load("formats/vicon_nexus_excel_resaved__pyomeca_markers_first200.csv") else {
        return;
    };
    is(&recording, Format::ViconNexus, 100.0, 200, 51);
    assert_eq!(recording.markers[0].name, "boite:gauche_ext");
    assert_eq!(recording.markers[8].name, "Daphnee:ASISr");
    assert_eq!(recording.markers[0].position[0], Some([44.1628, -276.862, 675.697].map(|mm| mm / 1e3)));
    says(&recording, "unit: mm, as line 5 states");
    assert_eq!(lost(&recording), 123);
}

#[test]
fn nexus_model_outputs_are_refused() {
    let Some(path) = sample("formats/vicon_nexus_model_outputs__pyCGM_Movement_trial_first55.csv") else {
        return;
    };
    let error = read(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("holds `Model Outputs` and no `Trajectories`"), "{error}");
}

#[test]
fn older_vicon() {
    let Some(recording) = load("formats/vicon_legacy_Title_header__pyCGM_Sample_Static_first60.csv") else {
        return;
    };
    is(&recording, Format::ViconLegacy, 100.0, 49, 141);
    assert_eq!(lost(&recording), 0);
    assert_eq!(recording.markers[0].name, "LFHD");
    assert_eq!(
        recording.markers[0].position[0],
        Some([174.5749207, 324.513031, 1728.94397].map(|mm| mm / 1e3))
    );
    says(&recording, "unit: mm is assumed");
}

#[test]
fn qualisys_excerpt() {
    let Some(recording) = load("formats/qualisys_tsv_NaN__dfki_recording_excerpt.tsv") else { return };
    is(&recording, Format::Qualisys, 100.0, 400, 21);
    assert_eq!(recording.time[0], 8.25);
    assert_eq!(recording.markers[0].position[0], Some([274.680, 235.368, 323.678].map(|mm| mm / 1e3)));
    says(&recording, "unit: mm is assumed");
    says(&recording, "the header states 6000 samples, the file has 400");
    assert_eq!(lost(&recording), 62);
}

#[test]
fn trc_between_commas() {
    let Some(recording) = load("formats/trc__pyomeca_markers_first40.trc") else { return };
    is(&recording, Format::Trc, 100.0, 34, 51);
    assert_eq!((recording.markers[50].name.as_str(), lost(&recording)), ("boite_arriere_gauche", 0));
    says(&recording, "unit: mm, as Units in line 3 states");
    says(&recording, "the header states 652 samples, the file has 34");
}

#[test]
fn the_silicone_beam_twice() {
    let (Some(c3d), Some(csv)) =
        (load("silicone_beam/gravity.c3d"), load("silicone_beam/gravity_clamp_frame.csv"))
    else {
        return;
    };
    is(&c3d, Format::C3d, 100.0, 500, 6);
    is(&csv, Format::Tidy, 100.0, 500, 6);
    assert_eq!((lost(&c3d), lost(&csv)), (0, 0));
    says(&c3d, "unit: m, as POINT:UNITS states");
    assert_eq!(c3d.markers[0].name, "Tip - 1");
    // The two are in different frames; distances between markers are not. The CSV has 0.1 µm.
    let distance = |recording: &Recording, sample: usize| {
        let at = |marker: usize| recording.markers[marker].position[sample].expect("seen");
        let (a, b) = (at(0), at(1));
        (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
    };
    for sample in [0, 250, 499] {
        assert!((distance(&c3d, sample) - distance(&csv, sample)).abs() < 3e-7);
    }
    // The markers' noise is 2 to 4 µm.
    let noise = c3d.markers[0].quality().noise.expect("seen");
    assert!(noise.iter().all(|noise| (1e-6..8e-6).contains(noise)), "{noise:?}");
}

#[test]
fn the_arm_and_the_trunk() {
    for pressure in [100, 200, 300] {
        let Some(recording) = load(&format!("pneumatic_arm/{pressure}mbar.csv")) else { return };
        is(&recording, Format::Tidy, 100.0, 600, 7);
    }
    for (id, samples) in [(0, 453), (1, 407), (2, 469)] {
        let Some(recording) = load(&format!("trunk/manual_decay_300g_id0{id}.csv")) else { return };
        is(&recording, Format::Tidy, 100.0, samples, 3);
        assert_eq!(lost(&recording), 0);
    }
}
