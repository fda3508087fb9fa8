//! The figures as a page.

use std::time::SystemTime;

use super::super::page::{BeforeUse, Page, Table, extrapolated};
use super::super::picture::{Picture, in_psi, model_name, models};
use super::super::report::significant;
use super::super::{Request, assumed};
use super::Words;
use crate::figures::Pressure;

/// The page of the figures; `written` is when.
pub(super) fn page(
    request: &Request,
    all: &[Pressure],
    pictures: &[Picture],
    words: &[Words],
    written: SystemTime,
) -> String {
    let lead = format!(
        "Figures 4 to 9 of Garbulinski and Wereley (2022), from {} simulated releases. Nothing in them was measured: the paper publishes its tables and trends, and neither paths nor markers. Each figure stands beside what the paper's shows and how ours differs.",
        all.len()
    );
    let mut page = Page::new("Figures 4 to 9 from our own runs", "Redrawn from simulations", &lead);
    let (extrapolated, warnings) = extrapolated(&request.warnings);
    let mut assumed = vec![
        "The tip at rest of each run stands for the measured one. The runs have the EI of Table 2's rod of 32 nodes, a whole Voronoi length at the clamp and the resting mass per length, as that EI was fitted; --set says otherwise.".to_owned(),
    ];
    assumed.extend(all.first().map(|of| assumed::of_run(&of.summary)).unwrap_or_default());
    page.before_use(&BeforeUse {
        note: Some("What the paper does not publish is not drawn: of its own curves the tables' numbers and the text's trends alone.".to_owned()),
        warnings,
        extrapolated: Some(extrapolated),
        assumed,
        ..BeforeUse::default()
    });
    for (picture, of) in pictures.iter().zip(words) {
        page.section(&picture.title);
        page.remarks(&[("The paper's", &of.paper), ("Ours", &of.ours), ("How it differs", &of.differs)]);
        page.figure(picture);
        match of.number {
            5 => stiffness(&mut page, all),
            6 => errors(&mut page, all),
            _ => {}
        }
    }
    let own = vec![("runs".to_owned(), all.len().to_string())];
    page.facts_of(request, written, own);
    page.finish()
}

fn stiffness(page: &mut Page, all: &[Pressure]) {
    let row = |of: &Pressure| {
        let fitted = models().map(|nodes| of.fit(nodes).map(|fit| fit.bending_stiffness));
        let fitted = fitted.map(|ei| ei.map_or("-".to_owned(), |ei| significant(ei, 4)));
        let published = of.published.iter().map(|ei| significant(*ei, 4));
        [in_psi(of).to_string()].into_iter().chain(published).chain(fitted).collect()
    };
    let own: Vec<String> = models().map(|nodes| format!("{}, ours", model_name(nodes))).collect();
    let published = ["psi", "axial, Table 2", "Euler, Table 2", "PDER 32, Table 2"];
    let heads: Vec<&str> = published.into_iter().chain(own.iter().map(String::as_str)).collect();
    page.folded(
        "Figure 5 in numbers",
        &Table { caption: "EI in N m²", heads: &heads, rows: all.iter().map(row).collect() },
    );
}

fn errors(page: &mut Page, all: &[Pressure]) {
    let row = |of: &Pressure| {
        let errors = models().map(|nodes| of.tip_error(nodes));
        let errors = errors.map(|error| error.map_or("-".to_owned(), |error| format!("{:.3}", 1e3 * error)));
        [in_psi(of).to_string()].into_iter().chain(errors).collect()
    };
    let own: Vec<String> = models().map(model_name).collect();
    let heads: Vec<&str> = ["psi"].into_iter().chain(own.iter().map(String::as_str)).collect();
    page.folded(
        "Figure 6 in numbers",
        &Table {
            caption: "Tip error in mm; that of 32 nodes is none by construction",
            heads: &heads,
            rows: all.iter().map(row).collect(),
        },
    );
}
