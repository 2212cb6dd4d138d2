//! That each metric rises for each planted fault: a comparison that finds nothing wrong is worth nothing else.

use crate::{Image, Metric, compare};

const SIDE: usize = 32;

fn gradient() -> Vec<[f32; 3]> {
    (0..SIDE * SIDE).map(|i| [0.2 + 0.001 * (i % SIDE) as f32, 0.3, 0.25 + 0.002 * (i / SIDE) as f32]).collect()
}

fn image(rgb: Vec<[f32; 3]>) -> Image {
    Image::from_linear(SIDE, SIDE, rgb).unwrap()
}

/// Each metric of scenes and of displays.
fn rises(planted: &Image, by: &str) {
    let right = image(gradient());
    for metric in Metric::all() {
        for (planted, right) in [(planted, &right), (&planted.displayed(0.0), &right.displayed(0.0))] {
            let name = metric.name();
            let none = compare(right, right, metric).unwrap();
            assert_eq!((none.value, none.map), (0.0, vec![0.0; SIDE * SIDE]), "{name}");
            let found = compare(planted, right, metric).unwrap();
            assert!(found.value > 0.0, "{name} does not see {by}");
            assert_eq!(found.map.len(), SIDE * SIDE);
            assert!(found.map.iter().all(|value| value.is_finite() && *value >= 0.0), "{name}: {by}");
        }
    }
}

#[test]
fn one_pixel() {
    for at in [0, SIDE - 1, SIDE * SIDE / 2 + SIDE / 2, SIDE * SIDE - 1] {
        let mut rgb = gradient();
        rgb[at] = [0.9, 0.95, 0.9];
        let planted = image(rgb);
        rises(&planted, "a pixel");
        for metric in Metric::all() {
            let map = compare(&planted, &image(gradient()), metric).unwrap().map;
            let most = (0..map.len()).max_by(|&a, &b| map[a].total_cmp(&map[b])).unwrap();
            assert_eq!(most, at, "{} has it elsewhere", metric.name());
        }
    }
}

#[test]
fn one_channel() {
    for channel in 0..3 {
        let mut rgb = gradient();
        rgb.iter_mut().for_each(|rgb| rgb[channel] += 0.2);
        rises(&image(rgb), "a channel");
    }
}

#[test]
fn darker_mirrored_and_swapped() {
    rises(&image(gradient().iter().map(|rgb| rgb.map(|value| value * 0.5)).collect()), "half the light");
    rises(&image(gradient().iter().map(|&[r, g, b]| [b, r, g]).collect()), "swapped channels");
    let mut edge = gradient();
    edge.iter_mut().enumerate().filter(|(i, _)| i % SIDE >= SIDE / 2).for_each(|(_, rgb)| *rgb = [0.9, 0.9, 0.8]);
    let mirrored: Vec<_> = edge.chunks(SIDE).flat_map(|row| row.iter().rev().copied()).collect();
    for metric in Metric::all() {
        assert!(compare(&image(mirrored.clone()), &image(edge.clone()), metric).unwrap().value > 0.0);
    }
}

#[test]
fn larger_faults_score_more() {
    let right = image(gradient());
    for metric in Metric::all() {
        let values = [0.1, 0.2, 0.4].map(|offset| {
            let mut rgb = gradient();
            rgb.iter_mut().take(SIDE * (offset * 40.0) as usize).for_each(|rgb| *rgb = rgb.map(|v| v + offset as f32));
            compare(&image(rgb), &right, metric).unwrap().value
        });
        assert!(values.is_sorted_by(|a, b| a < b), "{}: {values:?}", metric.name());
    }
}
