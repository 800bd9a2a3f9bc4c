//! A checked chart in, the picture out: the only place that knows the drawing library, and all that makes the style.

use crate::chart::{Chart, Layer, Mark, Scale};
use kuva::prelude::{BarPlot, Layout, LegendPosition, LinePlot, MarkerShape, Plot, ScatterPlot};

/// Colours of the layers in turn: distinct for the colour-blind too (Okabe and Ito).
const COLOURS: [&str; 7] =
    ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"];
const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 520.0;
const FONT: &str = "DejaVu Sans, Verdana, sans-serif";

pub(crate) fn svg(chart: &Chart) -> String {
    let (plots, layout) = picture(chart);
    kuva::render_to_svg(plots, layout)
}

pub(crate) fn png(chart: &Chart) -> Result<Vec<u8>, String> {
    let (plots, layout) = picture(chart);
    kuva::render_to_raster(plots, layout, 1.5)
}

fn picture(chart: &Chart) -> (Vec<Plot>, Layout) {
    let plots: Vec<Plot> = chart
        .layers
        .iter()
        .zip(COLOURS.iter().cycle())
        .filter(|(layer, _)| !layer.points.is_empty())
        .map(|(layer, colour)| plot(layer, colour))
        .collect();
    let layout = Layout::auto_from_plots(&plots)
        .with_title(chart.title.as_str())
        .with_x_label(chart.x.label.as_str())
        .with_y_label(chart.y.label.as_str())
        .with_width(WIDTH)
        .with_height(HEIGHT)
        .with_font_family(FONT)
        .with_title_size(16)
        .with_legend_position(LegendPosition::OutsideRightTop);
    let layout = if chart.x.scale == Scale::Log { layout.with_log_x() } else { layout };
    let layout = if chart.y.scale == Scale::Log { layout.with_log_y() } else { layout };
    (plots, layout)
}

fn plot(layer: &Layer, colour: &str) -> Plot {
    let points = layer.points.iter().copied();
    match layer.mark {
        Mark::Line | Mark::DashedLine => {
            let line = LinePlot::new().with_data(points).with_color(colour).with_stroke_width(1.5);
            let line = if layer.mark == Mark::DashedLine { line.with_dashed() } else { line };
            if layer.name.is_empty() {
                line.into()
            } else {
                line.with_legend(layer.name.as_str()).into()
            }
        }
        Mark::Bars => {
            let bars =
                layer.labels.iter().zip(&layer.points).map(|(label, (_, y))| (label.as_str(), *y));
            BarPlot::new().with_bars(bars).with_color(colour).into()
        }
        Mark::Circles | Mark::Triangles | Mark::TrianglesDown => {
            let shape = match layer.mark {
                Mark::Triangles => MarkerShape::Triangle,
                Mark::TrianglesDown => MarkerShape::TriangleDown,
                _ => MarkerShape::Circle,
            };
            let markers = ScatterPlot::new()
                .with_data(points)
                .with_color(colour)
                .with_size(4.5)
                .with_marker(shape);
            let markers = if layer.labels.is_empty() {
                markers
            } else {
                markers.with_labels(layer.labels.iter().map(String::as_str)).with_repel_labels()
            };
            if layer.name.is_empty() {
                markers.into()
            } else {
                markers.with_legend(layer.name.as_str()).into()
            }
        }
    }
}
