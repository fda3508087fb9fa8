//! The exports of the module: bytes of a request go in, bytes of an answer come out.
//!
//! ```text
//! room(length) ─▶ address; the page writes a request there ─▶ answer() ─▶ length; address() says where it is
//! ```
//!
//! The page reads and writes the module's memory; the module itself touches only vectors that it owns. So no code here
//! is unsafe. Exported names are called so by the compiler, because two of one name would collide.
#![allow(unsafe_code, reason = "no_mangle is an unsafe attribute; there is no unsafe block")]

use std::cell::RefCell;

use crate::Playground;

#[derive(Default)]
struct Desk {
    playground: Playground,
    text: Vec<u8>,
}

thread_local! {
    static DESK: RefCell<Desk> = RefCell::default();
}

/// Makes room for a request of so many bytes, and says where.
#[unsafe(no_mangle)]
pub extern "C" fn room(length: usize) -> *mut u8 {
    DESK.with_borrow_mut(|desk| {
        desk.text.clear();
        desk.text.resize(length, 0);
        desk.text.as_mut_ptr()
    })
}

/// Answers the request, and says how many bytes the answer has.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> usize {
    DESK.with_borrow_mut(|desk| {
        let request = String::from_utf8_lossy(&desk.text);
        desk.text = desk.playground.answer(&request).into_bytes();
        desk.text.len()
    })
}

/// Where the answer is.
#[unsafe(no_mangle)]
pub extern "C" fn address() -> *const u8 {
    DESK.with_borrow(|desk| desk.text.as_ptr())
}
