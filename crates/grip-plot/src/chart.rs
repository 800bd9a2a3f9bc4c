//! What a chart shows.

use crate::draw;
use std::path::Path;

/// How an axis is divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// The same, from 0 to 100 whatever is shown.
    Percent,
    /// By decades; every number must be positive.
    Log,
}

/// One axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// What it shows, with the unit.
    pub label: String,
    /// How it is divided.
    pub scale: Scale,
}

impl Axis {
    /// An evenly divided axis.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Linear }
    }

    /// An axis of shares (%).
    pub fn percent(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Percent }
    }

    /// An axis divided by decades.
    pub fn log(label: impl Into<String>) -> Self {
        Self { label: label.into(), scale: Scale::Log }
    }
}

/// How a layer is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Points joined by a line.
    Line,
    /// The same, dashed.
    DashedLine,
    /// Filled circles.
    Circles,
    /// Triangles, tip up.
    Triangles,
    /// Triangles, tip down.
    TrianglesDown,
    /// Bars from zero; each point is one bar, named by its label. Several layers of bars with the same labels stand
    /// beside each other.
    Bars,
}

/// One set of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Name in the legend; empty for none: such a layer has the colour of the one before it.
    pub name: String,
    /// How the points are drawn.
    pub mark: Mark,
    /// x and y of each point.
    pub points: Vec<(f64, f64)>,
    /// A text beside each point; empty for none.
    pub labels: Vec<String>,
}

impl Layer {
    /// A line through `points`.
    pub fn line(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), mark: Mark::Line, points, labels: Vec::new() }
    }

    /// Circles at `points`.
    pub fn markers(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { mark: Mark::Circles, ..Self::line(name, points) }
    }

    /// Bars of the named heights.
    pub fn bars(name: impl Into<String>, bars: Vec<(String, f64)>) -> Self {
        let points = bars.iter().enumerate().map(|(i, (_, height))| (i as f64, *height)).collect();
        let labels = bars.into_iter().map(|(label, _)| label).collect();
        Self { mark: Mark::Bars, labels, ..Self::line(name, points) }
    }

    /// Drawn as `mark`.
    #[must_use]
    pub fn drawn_as(self, mark: Mark) -> Self {
        Self { mark, ..self }
    }

    /// With a text beside each point.
    #[must_use]
    pub fn labelled(self, labels: Vec<String>) -> Self {
        Self { labels, ..self }
    }
}

/// A title, two axes and layers, the first one at the back; more of them below on the same horizontal axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// What the chart states.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn.
    pub layers: Vec<Layer>,
    /// Shaded behind the layers, here and below: where each begins and ends on the horizontal axis.
    pub spans: Vec<(f64, f64)>,
    /// Charts below this one, on its horizontal axis. Their own spans and what stands below them is not drawn.
    pub below: Vec<Chart>,
}

/// Why a chart cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// No layer has a point.
    #[error("the chart \"{0}\" has no points")]
    Empty(String),
    /// A number that has no place on its axis: not finite, or not positive on a logarithmic one.
    #[error("the chart \"{title}\" cannot show ({x}, {y}) of \"{layer}\"")]
    OffAxis {
        /// Title of the chart.
        title: String,
        /// Name of the layer.
        layer: String,
        /// First number of the point.
        x: f64,
        /// Second number of the point.
        y: f64,
    },
    /// Bars stand on an axis of names, so they share a chart with nothing but bars of the same names.
    #[error(
        "the chart \"{0}\" mixes bars with other layers or names, or puts them on a logarithmic axis"
    )]
    MixedBars(String),
    /// The name of the file states neither .svg nor .png.
    #[error("{0}: a chart is written as .svg or .png")]
    UnknownFormat(String),
    /// The picture could not be made.
    #[error("drawing failed: {0}")]
    Draw(String),
}

impl Chart {
    /// A chart without layers.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self { title: title.into(), x, y, layers: Vec::new(), spans: Vec::new(), below: Vec::new() }
    }

    /// With one more layer, in front of the others.
    #[must_use]
    pub fn with(mut self, layer: Layer) -> Self {
        self.layers.push(layer);
        self
    }

    /// With `spans` shaded.
    #[must_use]
    pub fn shaded(self, spans: Vec<(f64, f64)>) -> Self {
        Self { spans, ..self }
    }

    /// With `chart` below the others.
    #[must_use]
    pub fn above(mut self, chart: Self) -> Self {
        self.below.push(chart);
        self
    }

    /// The chart as SVG text.
    ///
    /// # Errors
    /// Where there is nothing to show, or a number has no place on its axis.
    pub fn svg(&self) -> Result<String, PlotError> {
        self.check()?;
        Ok(draw::svg(self))
    }

    /// The chart as the bytes of a PNG file.
    ///
    /// # Errors
    /// As [`Chart::svg`], and where the picture cannot be made.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        self.check()?;
        draw::png(self).map_err(PlotError::Draw)
    }

    /// The bytes of `file`, as its ending states: .svg or .png.
    ///
    /// # Errors
    /// As [`Chart::png`], and where the file has another ending.
    pub fn bytes(&self, file: &Path) -> Result<Vec<u8>, PlotError> {
        let ending = file.extension().and_then(|ending| ending.to_str()).unwrap_or("");
        match ending.to_ascii_lowercase().as_str() {
            "svg" => Ok(self.svg()?.into_bytes()),
            "png" => self.png(),
            _ => Err(PlotError::UnknownFormat(file.display().to_string())),
        }
    }

    /// Whether all layers are bars of the same names on evenly divided axes.
    fn bars_alike(&self) -> bool {
        let linear = [&self.x, &self.y].iter().all(|axis| axis.scale == Scale::Linear);
        let names = self.layers.first().map(|layer| &layer.labels);
        let alike = |layer: &Layer| layer.mark == Mark::Bars && Some(&layer.labels) == names;
        linear && self.layers.iter().all(alike)
    }

    fn check(&self) -> Result<(), PlotError> {
        self.below.iter().try_for_each(Self::check)?;
        if self.layers.iter().all(|layer| layer.points.is_empty()) {
            return Err(PlotError::Empty(self.title.clone()));
        }
        if self.layers.iter().any(|layer| layer.mark == Mark::Bars) && !self.bars_alike() {
            return Err(PlotError::MixedBars(self.title.clone()));
        }
        let fits = |value: f64, axis: &Axis| {
            value.is_finite() && (axis.scale != Scale::Log || value > 0.0)
        };
        for layer in &self.layers {
            if let Some(&(x, y)) =
                layer.points.iter().find(|(x, y)| !(fits(*x, &self.x) && fits(*y, &self.y)))
            {
                let (title, layer) = (self.title.clone(), layer.name.clone());
                return Err(PlotError::OffAxis { title, layer, x, y });
            }
        }
        match self.spans.iter().find(|(from, to)| !(fits(*from, &self.x) && fits(*to, &self.x))) {
            Some(&(x, y)) => {
                let (title, layer) = (self.title.clone(), "shaded".to_owned());
                Err(PlotError::OffAxis { title, layer, x, y })
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Axis, Chart, Layer, Mark, PlotError};
    use std::path::Path;

    fn chart() -> Chart {
        Chart::new("Error against time", Axis::log("ns"), Axis::log("relative error"))
            .with(
                Layer::line("front", vec![(1.0, 1e-16), (100.0, 1e-30)]).drawn_as(Mark::DashedLine),
            )
            .with(
                Layer::markers("split", vec![(1.0, 1e-16), (5.0, 1e-3)])
                    .labelled(vec!["f64 <split>".to_owned(), "naive".to_owned()]),
            )
    }

    #[test]
    fn a_chart_shows_its_texts_and_points() {
        let svg = chart().svg().unwrap();
        for text in ["Error against time", "relative error", "f64 &lt;split&gt;", "naive", "front"]
        {
            assert!(svg.contains(text), "{text} is missing in {svg}");
        }
        assert!(svg.matches("<circle").count() >= 2, "{svg}");
    }

    #[test]
    fn a_logarithmic_axis_reaches_as_far_as_its_points() {
        let points = vec![(1.0, 1e-30), (10.0, 1e-16), (100.0, 1e-2)];
        let chart = Chart::new("errors", Axis::log("ns"), Axis::log("error"));
        let svg = chart.with(Layer::markers("", points)).svg().unwrap();
        let places = |name: &str| -> Vec<f64> {
            let circles = svg.split("<circle").skip(1);
            circles
                .map(|circle| circle.split(name).nth(1).unwrap().split('"').nth(1).unwrap())
                .map(|number| number.parse().unwrap())
                .collect()
        };
        let (x, y) = (places(" cx="), places(" cy="));
        assert!((x[1] - x[0] - (x[2] - x[1])).abs() < 0.1 && x[1] > x[0] + 100.0, "{x:?}");
        assert!((y[0] - y[1] - (y[1] - y[2])).abs() < 0.1 && y[0] > y[1] + 100.0, "{y:?}");
        assert!(svg.contains("1e-15") && svg.contains("1e-30"));
    }

    #[test]
    fn a_file_is_what_its_ending_states() {
        let bytes = |name: &str| chart().bytes(Path::new(name));
        assert!(String::from_utf8(bytes("a.svg").unwrap()).unwrap().contains("</svg>"));
        assert!(bytes("a.PNG").unwrap().starts_with(b"\x89PNG"));
        let error = bytes("a.gif").unwrap_err();
        assert!(matches!(error, PlotError::UnknownFormat(_)), "{error}");
    }

    #[test]
    fn what_has_no_place_is_refused() {
        let empty = Chart::new("none", Axis::linear("x"), Axis::linear("y"));
        assert!(matches!(empty.svg(), Err(PlotError::Empty(_))));
        let zero = chart().with(Layer::markers("zero", vec![(1.0, 0.0)]));
        assert!(matches!(zero.svg(), Err(PlotError::OffAxis { y: 0.0, .. })));
        let nan = empty.clone().with(Layer::line("nan", vec![(0.0, f64::NAN)]));
        assert!(matches!(nan.svg(), Err(PlotError::OffAxis { .. })));
        let bars = Layer::bars("heights", vec![("a".to_owned(), 1.0), ("b".to_owned(), 2.0)]);
        assert!(empty.clone().with(bars.clone()).svg().unwrap().contains("<rect"));
        assert!(matches!(chart().with(bars.clone()).svg(), Err(PlotError::MixedBars(_))));
        let others = Layer::bars("others", vec![("a".to_owned(), 1.0)]);
        assert!(matches!(empty.with(bars).with(others).svg(), Err(PlotError::MixedBars(_))));
    }

    #[test]
    fn charts_below_share_the_axis_and_what_is_shaded() {
        let below = chart().with(Layer::line("second", vec![(1000.0, 1e-16)]));
        let alone = chart().svg().unwrap();
        let shaded = chart().shaded(vec![(1.0, 10.0)]).above(below.clone());
        let both = shaded.svg().unwrap();
        assert!(both.contains("second") && both.len() > alone.len());
        // One rectangle in each of the two.
        assert_eq!(both.matches(crate::draw::SHADE).count(), 2, "{both}");
        assert!(shaded.png().unwrap().starts_with(b"\x89PNG"));
        let bad = chart().shaded(vec![(0.0, 1.0)]);
        assert!(matches!(bad.svg(), Err(PlotError::OffAxis { x: 0.0, .. })));
        let empty = Chart::new("none", Axis::linear("x"), Axis::linear("y"));
        assert!(matches!(chart().above(empty).svg(), Err(PlotError::Empty(_))));
    }

    #[test]
    fn layers_of_bars_stand_beside_each_other() {
        let bars = |name: &str, a: f64, b: f64| {
            Layer::bars(name, vec![("first".to_owned(), a), ("second".to_owned(), b)])
        };
        let chart = Chart::new("errors", Axis::linear(""), Axis::linear("MSE"))
            .with(bars("train", 1.0, 2.0))
            .with(bars("test", 3.0, 4.0));
        let svg = chart.svg().unwrap();
        for text in ["train", "test", "first", "second"] {
            assert!(svg.contains(&format!(">{text}<")), "{text} is missing in {svg}");
        }
        for colour in ["#0072b2", "#d55e00"] {
            assert!(svg.matches(colour).count() >= 2, "{colour} in {svg}");
        }
    }
}
