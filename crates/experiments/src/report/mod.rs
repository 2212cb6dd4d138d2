//! What is made of results: a page that holds all, tables for programs, and plots.

mod claims;
mod csv;
mod html;
mod plot;

pub use claims::{claims, verdicts};
pub use csv::{csv, json};
pub use html::{STYLE, escaped, html, table};
pub use plot::svg;

use crate::figure::{Figure, Page, Results};

/// A figure with what it shows.
pub struct Made {
    /// The figure.
    pub figure: &'static Figure,
    /// What it shows.
    pub page: Page,
    /// Its plots as SVG.
    pub svgs: Vec<String>,
    /// What is missing, and why.
    pub skipped: Vec<String>,
}

/// Makes figures of results.
///
/// # Errors
/// What the plotting library says.
pub fn make(results: &Results, figures: &[&'static Figure]) -> Result<Vec<Made>, String> {
    let one = |figure: &&'static Figure| {
        let mut page = (figure.page)(results);
        // An empty plot says nothing.
        for chart in &mut page.charts {
            chart.lines.retain(|line| !line.points.is_empty());
        }
        page.charts.retain(|chart| !chart.lines.is_empty());
        let svgs: Result<_, String> = page.charts.iter().map(svg).collect();
        let skipped = results.skipped(&(figure.cases)(&results.scope));
        Ok(Made { figure, page, svgs: svgs?, skipped })
    };
    figures.iter().map(one).collect()
}
