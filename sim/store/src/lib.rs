//! Files of efam: written whole or not at all, read up to a bound, and tables in them.
//!
//! A run folder is a [`Folder`], a single file is written by [`atomic`], [`added`] adds to a folder, and [`manifest`]
//! says which files efam wrote.
//! [`input`] reads what somebody named, [`columns`] writes and reads tables.

pub mod added;
pub mod atomic;
pub mod columns;
pub mod disk;
mod error;
pub mod escape;
pub mod folder;
pub mod footer;
pub mod input;
pub mod manifest;
pub mod memory;
pub mod names;
pub mod partial;
pub mod sha;
mod utc;

pub use error::StoreError;
pub use folder::{Folder, MARK};
