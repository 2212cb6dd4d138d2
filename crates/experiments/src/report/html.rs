//! One page that holds all, without anything from elsewhere.

use super::Made;
use crate::claim::{Claim, Verdict};
use crate::figure::{Axis, Picture, Table};
use crate::store::Store;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use std::fmt::Write;

/// What pages look like.
pub const STYLE: &str = include_str!("style.css");

/// The page.
#[must_use]
pub fn html(store: &Store, made: &[Made]) -> String {
    let mut page = String::new();
    let device = escaped(&store.header.machine.title());
    let _ = write!(
        page,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>The thesis's experiments on {device}</title><style>{STYLE}</style></head><body>\n\
         <h1>“Photon Mapping on the GPU”, measured again</h1>\n"
    );
    introduction(&mut page, store);
    summary(&mut page, made);
    for made in made {
        figure(&mut page, made);
    }
    page += "</body></html>\n";
    page
}

fn introduction(page: &mut String, store: &Store) {
    let machine = &store.header.machine;
    let range = if store.header.quick { "cut short (--quick)" } else { "whole, and beyond the thesis's" };
    let rows = [
        ("Device", machine.title()),
        ("Driver", machine.driver.clone()),
        ("CPU", format!("{}, {} threads", machine.cpu, machine.threads)),
        ("Program", format!("caustic {}, commit {}, {}", machine.caustic, machine.commit, machine.rustc)),
        ("Begun", store.header.date.clone()),
        ("Ranges", range.to_string()),
        ("Command", store.header.command.clone()),
    ];
    *page += "<p>Each figure and table of chapter 5 of Fleisz's thesis (2009) that holds a measurement, from the same scene, with what the thesis \
              says of it and whether that holds here. All techniques are exact: their results are compared bit for bit. Times are medians. \
              Verdicts are computed from the data within the thesis's ranges.</p>\n<table class=\"facts\">";
    for (name, text) in rows.iter().filter(|row| !row.1.is_empty()) {
        let _ = write!(page, "<tr><th>{name}</th><td>{}</td></tr>", escaped(text));
    }
    *page += "</table>\n";
    let (same, compared) = agreement(store);
    let _ = writeln!(
        page,
        "<p><b>{same} of {compared}</b> searches by several techniques found the same neighbours in the same order (by SHA-256).</p>"
    );
}

/// Of the circumstances under which several subjects searched: those in which all found the same, and all.
fn agreement(store: &Store) -> (usize, usize) {
    let mut found: std::collections::HashMap<_, Vec<&str>> = std::collections::HashMap::new();
    for (case, _) in store.cases() {
        if let Some(hash) = store.found(case) {
            let circumstances = crate::case::Case { subject: String::new(), ..case.clone() };
            found.entry(circumstances).or_default().push(hash);
        }
    }
    let several = found.values().filter(|hashes| hashes.len() > 1);
    let same = several.clone().filter(|hashes| hashes.iter().all(|hash| *hash == hashes[0]));
    (same.count(), several.count())
}

fn summary(page: &mut String, made: &[Made]) {
    let claims = || made.iter().flat_map(|made| made.page.claims.iter().map(move |claim| (made, claim)));
    let count = |verdict| claims().filter(|(_, claim)| claim.verdict == verdict).count();
    let counts = [Verdict::Holds, Verdict::Partly, Verdict::Fails, Verdict::Unmeasured].map(|verdict| {
        format!("<span class=\"verdict {}\">{}: {}</span>", class(verdict), verdict.name(), count(verdict))
    });
    let _ = write!(page, "<h2>What holds</h2>\n<p>{}</p>\n<table class=\"claims\">", counts.join(" "));
    for (made, claim) in claims() {
        let _ = write!(
            page,
            "<tr><td><a href=\"#{0}\">{0}</a></td><td>{1}</td><td>{2}</td></tr>",
            made.figure.id,
            badge(claim),
            escaped(claim.says),
        );
    }
    *page += "</table>\n";
}

fn figure(page: &mut String, made: &Made) {
    let figure = made.figure;
    let _ = writeln!(
        page,
        "<section id=\"{0}\"><h2>{1}</h2><p class=\"of\">{0}, section {2}</p>",
        figure.id,
        escaped(figure.title),
        figure.section
    );
    for claim in &made.page.claims {
        let _ = writeln!(
            page,
            "<p class=\"claim\">{} {} <span class=\"because\">Here: {}</span></p>",
            badge(claim),
            escaped(claim.says),
            escaped(&claim.because)
        );
    }
    for svg in &made.svgs {
        let _ = writeln!(page, "<figure>{svg}</figure>");
    }
    for (chart, _) in made.page.charts.iter().zip(&made.svgs) {
        let rows = chart.lines.iter().flat_map(|line| {
            line.points.iter().map(|(x, y)| vec![line.label.clone(), format!("{x}"), format!("{y:.5}")])
        });
        let [x, y] = chart.axes.map(Axis::description);
        let columns = ["of", x, y].map(str::to_string).into();
        let title = format!("Numbers: {}", chart.title);
        table(page, &Table { title, columns, rows: rows.collect() }, true);
    }
    for of_page in &made.page.tables {
        table(page, of_page, false);
    }
    pictures(page, &made.page.pictures);
    if !made.page.note.is_empty() {
        let _ = writeln!(page, "<p class=\"note\">{}</p>", escaped(made.page.note));
    }
    if !made.skipped.is_empty() {
        let items: String = made.skipped.iter().map(|text| format!("<li>{}</li>", escaped(text))).collect();
        let _ = writeln!(
            page,
            "<details><summary>Not measured: {}</summary><ul>{items}</ul></details>",
            made.skipped.len()
        );
    }
    *page += "</section>\n";
}

/// Appends a table to a page, folded or open.
pub fn table(page: &mut String, table: &Table, folded: bool) {
    let title = escaped(&table.title);
    *page += &if folded { format!("<details><summary>{title}</summary>") } else { format!("<h3>{title}</h3>") };
    *page += "<table><tr>";
    for column in &table.columns {
        let _ = write!(page, "<th>{}</th>", escaped(column));
    }
    *page += "</tr>";
    for row in &table.rows {
        let cells: String = row.iter().map(|cell| format!("<td>{}</td>", escaped(cell))).collect();
        let _ = write!(page, "<tr>{cells}</tr>");
    }
    *page += if folded { "</table></details>\n" } else { "</table>\n" };
}

fn pictures(page: &mut String, pictures: &[Picture]) {
    if pictures.is_empty() {
        return;
    }
    *page += "<div class=\"pictures\">";
    for picture in pictures {
        let data = BASE64_STANDARD.encode(&picture.png);
        let caption = escaped(&picture.caption);
        let _ = write!(
            page,
            "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>"
        );
    }
    *page += "</div>\n";
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Holds => "holds",
        Verdict::Partly => "partly",
        Verdict::Fails => "fails",
        Verdict::Unmeasured => "unmeasured",
    }
}

fn badge(claim: &Claim) -> String {
    format!("<span class=\"verdict {}\">{}</span>", class(claim.verdict), claim.verdict.name())
}

/// The text as a page has it.
#[must_use]
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
