//! The figures as a page.

use std::time::SystemTime;

use crate::figures::Words;
use crate::page::{BeforeUse, Page, Table, extrapolated};
use crate::paper::{Origin, Pressure};
use crate::picture::{Picture, are_recorded, in_psi, model_name, models};
use crate::report::significant;
use crate::{Request, assumed};

/// The page of the figures; `written` is when.
pub(super) fn page(
    request: &Request,
    all: &[Pressure],
    pictures: &[Picture],
    words: &[Words],
    written: SystemTime,
) -> String {
    let recorded = are_recorded(all);
    let lead = if recorded {
        format!(
            "Figures 4 to 9 of Garbulinski and Wereley (2022), from {} recorded releases. Each figure stands beside the paper's results and the differences.",
            all.len()
        )
    } else {
        format!(
            "Figures 4 to 9 of Garbulinski and Wereley (2022), from {} simulated releases. Nothing in them was measured: the paper publishes its tables and trends, and neither paths nor markers. Each figure stands beside what the paper's shows and how ours differs.",
            all.len()
        )
    };
    let (title, word) = if recorded {
        (format!("Figures 4 to 9 from {}", request.name), "Drawn from recordings")
    } else {
        ("Figures 4 to 9 from our own runs".to_owned(), "Redrawn from simulations")
    };
    let mut page = Page::new(&title, word, &lead);
    let (extrapolated, warnings) = extrapolated(&request.warnings);
    let mut assumed = vec![if recorded { "The rod, its masses and its pressures are as the experiment file says. One release at each pressure counts: the lightest payload, a level base before an inclined one, then the representative." } else { "The tip at rest of each run stands for the measured one. The runs have the EI of Table 2's rod of 32 nodes, a whole Voronoi length at the clamp and the resting mass per length, as that EI was fitted; --set says otherwise." }
    .to_owned()];
    if let Some(Origin::Simulated(own)) = all.first().map(|of| &of.origin) {
        assumed.extend(assumed::of_run(&own.summary));
    }
    for (picture, of) in pictures.iter().zip(words) {
        page.section(&picture.title);
        page.remarks(&[("The paper's", &of.paper), ("Ours", &of.ours), ("How it differs", &of.differs)]);
        page.figure(picture);
        match of.number {
            5 => stiffness(&mut page, all, recorded),
            6 => errors(&mut page, all, recorded),
            _ => {}
        }
    }
    let name = if recorded { "releases" } else { "runs" };
    let own = vec![(name.to_owned(), all.iter().map(|of| of.name.clone()).collect::<Vec<_>>().join(", "))];
    page.before_use(&BeforeUse {
        note: Some("What the paper does not publish is not drawn: of its own curves the tables' numbers and the text's trends alone.".to_owned()),
        warnings,
        extrapolated: Some(extrapolated),
        assumed,
        ..BeforeUse::default()
    });
    page.facts_of(request, written, own);
    page.finish()
}

fn stiffness(page: &mut Page, all: &[Pressure], recorded: bool) {
    let row = |of: &Pressure| {
        let fitted = models().map(|nodes| of.fit(nodes).map(|fit| fit.bending_stiffness));
        let fitted = fitted.map(|ei| ei.map_or("-".to_owned(), |ei| significant(ei, 4)));
        let published = of.published.map(|ei| ei.map_or("-".to_owned(), |ei| significant(ei, 4)));
        [in_psi(of).to_string()].into_iter().chain(published).chain(fitted).collect()
    };
    let whose = if recorded { "recorded" } else { "ours" };
    let own: Vec<String> = models().map(|nodes| format!("{}, {whose}", model_name(nodes))).collect();
    let published = ["psi", "axial, table", "Euler, table", "PDER 32, table"];
    let heads: Vec<&str> = published.into_iter().chain(own.iter().map(String::as_str)).collect();
    page.folded(
        "Figure 5 in numbers",
        &Table { caption: "EI in N m²", heads: &heads, rows: all.iter().map(row).collect() },
    );
}

fn errors(page: &mut Page, all: &[Pressure], recorded: bool) {
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
            caption: if recorded {
                "Tip error in mm"
            } else {
                "Tip error in mm; that of 32 nodes is none by construction"
            },
            heads: &heads,
            rows: all.iter().map(row).collect(),
        },
    );
}
