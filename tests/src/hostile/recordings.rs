//! Recordings of any format, detected from their content.

use std::path::Path;

use efam_recordings::{Length, ReadOptions, parse};

use super::is_message;

/// A recording: what was read holds together.
pub fn recording(bytes: &[u8]) {
    let options = [
        ReadOptions::default(),
        ReadOptions { unit: Some(Length::Millimetre), rate_hz: Some(100.0), columns: None },
    ];
    for options in options {
        let recording = match parse(bytes.to_vec(), Path::new("a.csv"), &options) {
            Ok(recording) => recording,
            Err(error) => {
                is_message(&error.to_string());
                continue;
            }
        };
        assert!(recording.rate_hz > 0.0 && recording.rate_hz.is_finite());
        assert!(recording.time.len() >= 2);
        assert!(recording.time.windows(2).all(|pair| pair[1] > pair[0]));
        assert!(recording.findings.iter().map(String::len).sum::<usize>() < 20_000);
        for marker in &recording.markers {
            assert_eq!(marker.position.len(), recording.time.len());
            if let Some(orientation) = &marker.orientation {
                assert_eq!(orientation.len(), recording.time.len());
            }
            marker.quality();
        }
    }
}
