//! Plots as SVG.

use crate::figure::{Axis, Chart};
use caustic_bench::report::COLOURS;
use plotters::coord::combinators::BindKeyPoints;
use plotters::prelude::*;
use std::ops::Range;

/// Size, pixels.
const SIZE: (u32, u32) = (1020, 500);
/// What of it the plot takes; the rest says which line is whose.
const PLOT: i32 = 760;

/// A chart as SVG.
///
/// # Errors
/// What the plotting library says.
pub fn svg(chart: &Chart) -> Result<String, String> {
    let mut text = String::new();
    draw(chart, &mut text).map_err(|error| format!("{}: {error}", chart.name))?;
    Ok(text)
}

fn draw(chart: &Chart, text: &mut String) -> Result<(), Box<dyn std::error::Error>> {
    let points = || chart.lines.iter().flat_map(|line| line.points.iter());
    let range = |of: fn(&(f64, f64)) -> f64| {
        let positive = points().map(of).filter(|&x| x > 0.0);
        let (low, high) = positive.fold((f64::INFINITY, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
        // Room around a line, also of a single point; some range where there is none.
        if high > 0.0 { low / 1.3..high * 1.3 } else { 1.0..10.0 }
    };
    let (horizontal, vertical) = (range(|point| point.0), range(|point| point.1));
    let [across, up] = [&horizontal, &vertical].map(|range| range.clone().log_scale().with_key_points(ticks(range)));
    let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let (plot, beside) = root.split_horizontally(PLOT);
    let mut context = ChartBuilder::on(&plot)
        .caption(&chart.title, ("sans-serif", 17))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(74)
        .build_cartesian_2d(across, up)?;
    context
        .configure_mesh()
        .x_desc(chart.axes[0].description())
        .y_desc(chart.axes[1].description())
        .x_label_formatter(&|&x| number(chart.axes[0], x))
        .y_label_formatter(&|&y| number(chart.axes[1], y))
        .label_style(("sans-serif", 13))
        .light_line_style(BLACK.mix(0.05))
        .draw()?;
    let mut names = Vec::new();
    if let Some(to) = chart.thesis_to {
        let line = [(to, vertical.start), (to, vertical.end)];
        context.draw_series(DashedLineSeries::new(line, 5, 4, BLACK.mix(0.6).stroke_width(1)))?;
        names.push((BLACK.mix(0.6).stroke_width(1), "the thesis's range ends here"));
    }
    for line in &chart.lines {
        let colour = COLOURS[line.subject % COLOURS.len()];
        // Those beyond the colours are thinner.
        let style = colour.stroke_width(if line.subject < COLOURS.len() { 2 } else { 1 });
        context.draw_series(LineSeries::new(line.points.iter().copied(), style))?;
        context.draw_series(line.points.iter().map(|&point| Circle::new(point, 3, colour.filled())))?;
        names.push((style, &line.label));
    }
    for ((style, name), y) in names.into_iter().zip((50..).step_by(22)) {
        beside.draw(&PathElement::new(vec![(8, y + 7), (28, y + 7)], style))?;
        beside.draw(&Text::new(name, (36, y), ("sans-serif", 13)))?;
    }
    root.present()?;
    Ok(())
}

/// Where a logarithmic axis has lines with numbers: powers of ten, where they are few also their doubles and fives, and even steps
/// where those are few.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let within = |all: Vec<f64>| -> Vec<f64> { all.into_iter().filter(|x| range.contains(x)).collect() };
    let decades = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let of = |factors: &[f64]| {
        within(decades.clone().flat_map(|n| factors.iter().map(move |f| f * 10f64.powi(n))).collect())
    };
    let (tens, more) = (of(&[1.0]), of(&[1.0, 2.0, 5.0]));
    if tens.len() >= 4 {
        return tens;
    }
    if more.len() >= 3 {
        return more;
    }
    let rough = (range.end - range.start) / 4.0;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|f| f * power).into_iter().find(|&step| step >= rough).unwrap_or(rough);
    within((1..).map(|n| f64::from(n) * step).take_while(|&x| x < range.end).collect())
}

/// A number on an axis, short.
fn number(axis: Axis, x: f64) -> String {
    let short = |x: f64, unit: &str| {
        // Five digits: what is beyond them comes of adding up steps.
        let text = format!("{}", format!("{x:.4e}").parse().unwrap_or(x));
        format!("{text}{unit}")
    };
    match axis {
        Axis::Bytes if x >= 1e9 => short(x / 1e9, " GB"),
        Axis::Bytes if x >= 1e6 => short(x / 1e6, " MB"),
        Axis::Bytes if x >= 1e3 => short(x / 1e3, " kB"),
        Axis::Time | Axis::Radius | Axis::K => short(x, ""),
        Axis::RelMse => format!("{x:.0e}"),
        _ if x >= 1e9 => short(x / 1e9, " G"),
        _ if x >= 1e6 => short(x / 1e6, " M"),
        _ if x >= 1e3 => short(x / 1e3, " k"),
        _ => short(x, ""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Line;

    fn chart(lines: Vec<Line>) -> Chart {
        let axes = [Axis::Photons, Axis::Time];
        Chart { name: "a".to_string(), title: "A title".to_string(), axes, thesis_to: Some(5e5), lines }
    }

    #[test]
    fn every_axis_has_numbers_whatever_it_spans() {
        assert_eq!(ticks(&(0.5..3e5)), [1.0, 10.0, 100.0, 1e3, 1e4, 1e5]);
        assert_eq!(ticks(&(7e3..3e5)), [1e4, 2e4, 5e4, 1e5, 2e5]);
        assert_eq!(ticks(&(61.0..89.0)), [70.0, 80.0]);
        assert_eq!(ticks(&(1.0..1.9)), [1.0, 1.5]);
        for spans in [1.7, 2.0, 5.0, 30.0, 1e3, 1e9] {
            for start in [1e-7, 0.3, 1.0, 7.7, 9.9, 4.2e8] {
                let count = ticks(&(start..start * spans)).len();
                assert!((2..=10).contains(&count), "{count} from {start} over {spans}");
            }
        }
        assert_eq!([61.0, 0.3, 1.5e4, 70.0 * 3.0].map(|x| number(Axis::Photons, x)), ["61", "0.3", "15 k", "210"]);
    }

    #[test]
    fn a_plot_names_axes_lines_and_the_end_of_the_thesis() {
        let line = Line { subject: 1, label: "some".to_string(), points: vec![(1e4, 0.5), (1e6, 40.0)] };
        let text = svg(&chart(vec![line])).unwrap();
        for part in ["<svg", "A title", "photons", "time, ms", "some", "range ends here", "100 k", "</svg>"] {
            assert!(text.contains(part), "no {part} in {text}");
        }
    }

    #[test]
    fn a_plot_of_nothing_is_no_error() {
        assert!(svg(&chart(vec![])).unwrap().contains("</svg>"));
        let line = Line { subject: 0, label: "zero".to_string(), points: vec![(1.0, 0.0)] };
        assert!(svg(&chart(vec![line])).is_ok());
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(Axis::Bytes, 3e6), "3 MB");
        assert_eq!(number(Axis::Photons, 5e5), "500 k");
        assert_eq!(number(Axis::Time, 0.5), "0.5");
    }
}
