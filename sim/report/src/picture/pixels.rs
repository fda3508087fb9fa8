//! Sizes on a picture, and its fonts.

/// Fine pixels in one of the picture.
pub const SCALE: i32 = 4;
/// Fonts, the first that is there.
pub const FONT: &str = "Helvetica, Arial, DejaVu Sans, sans-serif";

/// Fine pixels of a length in pixels.
pub fn px(length: f64) -> i32 {
    (length * f64::from(SCALE)).round() as i32
}
