//! The program `efam`.
fn main() {}
