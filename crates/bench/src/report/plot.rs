//! Time over N, one SVG a case.

use super::{OURS, Series, series};
use crate::row::Row;
use plotters::prelude::*;

/// Size of a plot, pixels.
const SIZE: (u32, u32) = (760, 480);
/// Colours of series, the first seven so that they differ for every kind of eyes (Okabe and Ito, "Color Universal Design", 2008).
pub const COLOURS: [RGBColor; 10] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(140, 86, 75),
    RGBColor(150, 150, 150),
    RGBColor(120, 94, 240),
];

/// The name and the SVG of each case that was measured. `device` is whose times ours are.
///
/// # Errors
/// What the plotting library says.
pub fn plots(rows: &[Row], device: &str) -> Result<Vec<(String, String)>, String> {
    let all = series(rows);
    let mut plots = Vec::new();
    let mut rest = &all[..];
    while let Some(first) = rest.first() {
        let (of_case, after) = rest.split_at(rest.iter().take_while(|series| series.case == first.case).count());
        plots.push((first.case.to_string(), plot(of_case, device).map_err(|error| error.to_string())?));
        rest = after;
    }
    Ok(plots)
}

fn plot(all: &[Series<'_>], device: &str) -> Result<String, Box<dyn std::error::Error>> {
    let points = || all.iter().flat_map(|series| series.points.iter());
    let range = |of: &dyn Fn(&(u32, f64)) -> f64| {
        let (low, high) = points().map(of).fold((f64::INFINITY, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
        // A little room, also for a single point.
        low / 1.5..high * 1.5
    };
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(format!("{}: time over N", all[0].case), ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(range(&|p| f64::from(p.0)).log_scale(), range(&|p| p.1).log_scale())?;
        chart
            .configure_mesh()
            .x_desc(format!("N, {}", all[0].counts))
            .y_desc("median time, ms")
            .x_label_formatter(&|n| format!("{n:.0e}"))
            .y_label_formatter(&|ms| if *ms >= 1.0 { format!("{ms:.0}") } else { format!("{ms}") })
            .label_style(("sans-serif", 13))
            .draw()?;
        for (i, series) in all.iter().enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            let points: Vec<_> = series.points.iter().map(|&(n, ms)| (f64::from(n), ms)).collect();
            let label = if series.who == OURS { format!("caustic, {device}") } else { series.who.to_string() };
            chart
                .draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(2)))?
                .label(label)
                .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 18, y)], colour.stroke_width(2)));
            chart.draw_series(points.iter().map(|&point| Circle::new(point, 3, colour.filled())))?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .label_font(("sans-serif", 13))
            .draw()?;
        root.present()?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::rows;

    #[test]
    fn a_plot_names_its_axes_and_series() {
        let plots = plots(&rows(), "some CPU").unwrap();
        assert_eq!(plots.len(), 1, "what was skipped has no plot");
        let (name, svg) = &plots[0];
        assert_eq!(name, "case-a");
        for part in ["<svg", "median time, ms", "N, photons", "caustic, some CPU", "other", "</svg>"] {
            assert!(svg.contains(part), "no {part} in {svg}");
        }
    }
}
