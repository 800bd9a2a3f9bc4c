//! Drawing of a checked chart: the only place that knows the drawing library, and all that makes the style.

use crate::chart::{Axis, Chart, Layer, Mark, Scale};
use kuva::backend::raster::RasterBackend;
use kuva::prelude::{
    BarPlot, Figure, Layout, LegendPosition, LinePlot, MarkerShape, Plot, ScatterPlot,
    ShadedRegion, SvgBackend, TickFormat,
};
use kuva::render::render::{Scene, render_multiple};
use std::sync::Arc;

/// Colours of the layers in turn: distinct for the colour-blind too (Okabe and Ito).
const COLOURS: [&str; 7] =
    ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"];
const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 520.0;
const FONT: &str = "DejaVu Sans, Verdana, sans-serif";

/// Height of each of several charts, and what is left of and right of their axes, so that these stand below each other.
const ROW: f64 = 300.0;
const SIDES: (f64, f64) = (90.0, 170.0);
pub(crate) const SHADE: &str = "#fad7a0";

pub(crate) fn svg(chart: &Chart) -> String {
    SvgBackend.render_scene(&scene(chart))
}

pub(crate) fn png(chart: &Chart) -> Result<Vec<u8>, String> {
    RasterBackend::new().with_scale(1.5).render_scene(&scene(chart))
}

fn scene(chart: &Chart) -> Scene {
    let shade = |layout: Layout| {
        let regions = chart.spans.iter().map(|&(from, to)| {
            ShadedRegion::vertical(place(from, &chart.x), place(to, &chart.x))
                .with_color(SHADE)
                .with_opacity(0.6)
        });
        regions.fold(layout, Layout::with_shaded_region)
    };
    let (plots, layout) = picture(chart);
    if chart.below.is_empty() {
        return render_multiple(plots, shade(layout));
    }
    let rows = [(plots, layout)].into_iter().chain(chart.below.iter().map(picture));
    let (plots, layouts): (Vec<_>, Vec<_>) = rows
        .map(|(plots, layout)| (plots, shade(layout.with_force_margins(SIDES.0, SIDES.1))))
        .unzip();
    let figure = Figure::new(plots.len(), 1)
        .with_cell_size(WIDTH, ROW)
        .with_shared_x_all()
        .with_spacing(0.0);
    figure.with_plots(plots).with_layouts(layouts).render()
}

fn picture(chart: &Chart) -> (Vec<Plot>, Layout) {
    let mut colours = COLOURS.iter().cycle();
    let mut colour = COLOURS[0];
    let mut layers: Vec<Plot> = Vec::new();
    for (at, layer) in chart.layers.iter().enumerate() {
        if at == 0 || !layer.name.is_empty() {
            colour = colours.next().unwrap_or(&COLOURS[0]);
        }
        if !layer.points.is_empty() {
            layers.push(plot(chart, layer, colour));
        }
    }
    let plots = grouped_bars(chart).map_or(layers, |bars| vec![bars]);
    let layout = Layout::auto_from_plots(&plots)
        .with_title(chart.title.as_str())
        .with_x_label(chart.x.label.as_str())
        .with_y_label(chart.y.label.as_str())
        .with_width(WIDTH)
        .with_height(HEIGHT)
        .with_font_family(FONT)
        .with_title_size(16)
        .with_legend_position(LegendPosition::OutsideRightTop);
    let layout = match decades(chart, &chart.x, |point| point.0) {
        Some((min, max, step)) => layout
            .with_x_axis_min(min)
            .with_x_axis_max(max)
            .with_x_tick_step(step)
            .with_x_tick_format(power_of_ten()),
        None => layout,
    };
    let layout = match decades(chart, &chart.y, |point| point.1) {
        Some((min, max, step)) => layout
            .with_y_axis_min(min)
            .with_y_axis_max(max)
            .with_y_tick_step(step)
            .with_y_tick_format(power_of_ten()),
        None if chart.y.scale == Scale::Percent => {
            layout.with_y_axis_min(0.0).with_y_axis_max(105.0).with_y_tick_step(20.0)
        }
        None => layout,
    };
    (plots, layout)
}

/// Exponents where a logarithmic axis begins and ends, and the decades from tick to tick. The library's own
/// logarithmic axes end at 1e-10, so points are placed by their exponents.
fn decades(chart: &Chart, axis: &Axis, of: fn(&(f64, f64)) -> f64) -> Option<(f64, f64, f64)> {
    if axis.scale != Scale::Log {
        return None;
    }
    let exponents = chart.layers.iter().flat_map(|layer| &layer.points).map(|p| of(p).log10());
    let (low, high) =
        exponents.fold((f64::MAX, f64::MIN), |(low, high), e| (low.min(e), high.max(e)));
    let (low, high) = (low.floor(), high.ceil().max(low.floor() + 1.0));
    let step = ((high - low) / 10.0).ceil();
    Some((low, low + step * ((high - low) / step).ceil(), step))
}

fn power_of_ten() -> TickFormat {
    TickFormat::Custom(Arc::new(|exponent: f64| {
        if (-2.0..=4.0).contains(&exponent) {
            format!("{}", 10.0_f64.powf(exponent.round()))
        } else {
            format!("1e{exponent:.0}")
        }
    }))
}

fn place(value: f64, axis: &Axis) -> f64 {
    match axis.scale {
        Scale::Linear | Scale::Percent => value,
        Scale::Log => value.log10(),
    }
}

/// Several layers of bars as one plot; their labels are the same.
fn grouped_bars(chart: &Chart) -> Option<Plot> {
    let first = chart.layers.first().filter(|layer| layer.mark == Mark::Bars)?;
    if chart.layers.len() < 2 {
        return None;
    }
    let mut bars = BarPlot::new();
    for (at, label) in first.labels.iter().enumerate() {
        let heights =
            chart.layers.iter().zip(COLOURS.iter().cycle()).filter_map(|(layer, colour)| {
                layer.points.get(at).map(|(_, height)| (*height, *colour))
            });
        bars = bars.with_group(label.as_str(), heights);
    }
    Some(bars.with_legend(chart.layers.iter().map(|layer| layer.name.as_str()).collect()).into())
}

fn plot(chart: &Chart, layer: &Layer, colour: &str) -> Plot {
    let points = layer.points.iter().map(|(x, y)| (place(*x, &chart.x), place(*y, &chart.y)));
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
