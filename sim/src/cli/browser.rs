//! The page of a run in the user's browser. The door to opener, which heeds `$BROWSER`.

use std::path::{Path, absolute};

use efam_report::page::REPORT;

use super::console::Console;

/// Shows the page of a folder on request. Results exist without a browser, so its lack is a warning.
pub fn show(is_asked: bool, folder: &Path, console: &Console) {
    let page = folder.join(REPORT);
    if !is_asked {
        return;
    }
    if !page.is_file() {
        console.warn([format!("--open: {}: has no {REPORT} to show", folder.display())]);
        return;
    }
    let whole = absolute(&page).unwrap_or_else(|_| page.clone());
    match opener::open_browser(&whole) {
        Ok(()) => console.detail(format!("shows {}", page.display())),
        Err(error) => console.warn([format!(
            "--open: no browser can be started ({error}); open {} yourself, or name a browser in BROWSER",
            page.display()
        )]),
    }
}
