//! The report of a study: the paper's Table 2 and Fig. 7 beside ours and a verdict on each of its sentences, the questions of its
//! conclusion, then all conditions.

use super::claims::Claims;
use super::{ConditionResult, NETS, NetResult, Study, StudyConfig, distances};
use crate::chapter::Beyond;
use crate::report::Block;
use crate::{
    Cell, Figure, Report, Section, Table, Tolerance,
    condition::{DEFAULT, Group},
};
use grip_plot::{Axis, Chart, Layer, Mark};
use serde_json::{Value, json};

/// The source study.
const PAPER: &str = "Grasping Force Estimation Recognizing Object Slippage by Tactile Data Using Neural Network (the text at hand \
                     names no authors)";

/// Conditions whose curves are drawn; the others are in the table of all conditions, and everything in the JSON.
const SHOWN: [&str; 2] = ["paper", DEFAULT.name];

impl Study {
    /// The report; `claims` are the paper's sentences, judged, and `beyond` other learners on the same rows.
    #[must_use]
    pub fn report(&self, claims: Option<&Claims>, beyond: &[Beyond]) -> Report {
        let mut report = Report {
            title: "The study of the four nets, repeated and explained".to_owned(),
            summary: summary(self),
            fields: self.fields(),
            ..Report::default()
        };
        let paper = self.result("paper");
        let mut first = Section::new("source", "The paper and its repetition");
        if let Some(paper) = paper {
            first = first.with(beside(&self.config, paper)).with(fig_7(paper));
        }
        report.push(match claims {
            Some(claims) => first.with(claims.table()),
            None => first,
        });
        report.push(questions(self, beyond));
        report.push(overview(self));
        for result in SHOWN.iter().filter_map(|name| self.result(name)) {
            let name = result.condition.name;
            let section = Section::new(name, format!("In detail: {}", result.condition.title()));
            report.push(figures(result).into_iter().fold(section, Section::with));
        }
        report
    }

    fn fields(&self) -> serde_json::Map<String, Value> {
        let config = &self.config;
        let results: Vec<Value> = self.results.iter().map(result_json).collect();
        let fields = json!({
            "type": "study",
            "seed": config.seed,
            "repeats": config.repeats,
            "draws": config.draws,
            "epochs": config.epochs,
            "goal": config.goal,
            "hidden": config.hidden,
            "known_rows": config.known_rows,
            "tolerances": Tolerance::ALL.map(Tolerance::key),
            "distances": distances(self),
            "results": results,
        });
        match fields {
            Value::Object(fields) => fields,
            _ => serde_json::Map::new(),
        }
    }
}

fn result_json(result: &ConditionResult) -> Value {
    let condition = &result.condition;
    json!({
        "condition": condition.name,
        "title": condition.title(),
        "group": condition.group.title(),
        "inputs": condition.features.inputs,
        "target": condition.features.target,
        "speed_noise": condition.speed_noise,
        "force_noise": condition.force_noise,
        "train_rows": condition.train_rows,
        "test_rows": condition.test_rows,
        "ceiling": result.ceiling,
        "nets": result.nets,
        "gp": result.gp,
    })
}

/// The paper, and a line for the paper-like condition and the shipped features.
fn summary(study: &Study) -> Vec<String> {
    let line = |result: &ConditionResult| {
        let shares = result.unseen();
        let shares: Vec<String> =
            shares.iter().map(|(name, share)| format!("{name} {:.0}", 100.0 * share)).collect();
        format!(
            "{}: {} % of unseen answers within 10 %; best possible {:.0} %",
            result.condition.title(),
            shares.join(", "),
            100.0 * result.ceiling.within_10pct
        )
    };
    let results = SHOWN.iter().filter_map(|name| study.result(name)).map(line);
    core::iter::once(format!("Paper: {PAPER}.")).chain(results).collect()
}

/// Table 2 beside the published one.
fn beside(config: &StudyConfig, result: &ConditionResult) -> Table {
    let caption = format!(
        "Table 2. Correct answers in percent, within 10 % of the adequate force (the paper does not define correct). Draws of rows: {}, \
         their mean is shown; starts: {}, the one nearest the average counts; at most {} epochs; condition: {}. Best possible on unseen rows: {:.1}",
        config.draws,
        config.repeats,
        config.epochs,
        result.condition.title(),
        100.0 * result.ceiling.within_10pct
    );
    let heads =
        ["net", "train", "train, published", "60 test rows", "test, published", "2000 unseen rows"];
    let mut table = Table::new("table-2", caption, &heads);
    for (net, found) in NETS.iter().zip(&result.nets) {
        let published =
            |which: usize| net.published.map_or(Cell::Empty, |shares| Cell::Percent(shares[which]));
        table.push(vec![
            Cell::text(net.title()),
            Cell::Percent(found.mean(|scores| scores.train.within_10pct())),
            published(0),
            Cell::Percent(found.mean(|scores| scores.test.within_10pct())),
            published(1),
            Cell::Percent(found.mean(|scores| scores.unseen.within_10pct())),
        ]);
    }
    let gp = |of: fn(&crate::Scores) -> f64| {
        Cell::Percent(result.gp.iter().map(of).sum::<f64>() / result.gp.len() as f64)
    };
    table.push(vec![
        Cell::text("GP, no net"),
        gp(|scores| scores.train.within_10pct()),
        Cell::Empty,
        gp(|scores| scores.test.within_10pct()),
        Cell::Empty,
        gp(|scores| scores.unseen.within_10pct()),
    ]);
    table
}

/// What the conclusion of the paper leaves open, each question with one answer a condition.
fn questions(study: &Study, beyond: &[Beyond]) -> Section {
    let conditions = crate::chapter::CONDITIONS;
    let mut table = Table::new(
        "questions",
        "Unseen answers within 10 %, percent. Nets, GP: mean of the draws; the others: first draw, a quarter of the rows held back to choose by",
        &[&["question of the conclusion", "answer by"][..], &conditions].concat(),
    );
    let mut row = |question: &str, by: &str, of: &dyn Fn(&str) -> Option<f64>| {
        let cells = conditions.iter().map(|name| of(name).map_or(Cell::Empty, Cell::Percent));
        table.push([Cell::text(question), Cell::text(by)].into_iter().chain(cells).collect());
    };
    let share = |condition: &str, learner: &str| {
        let shares = study.result(condition)?.unseen();
        shares.into_iter().find(|(name, _)| name == learner).map(|(_, share)| share)
    };
    let learned = |condition: &str, learner: &str| {
        let of = beyond.iter().find(|beyond| beyond.condition.name == condition)?;
        Some(of.learner(learner)?.test.within_10pct)
    };
    for net in ["M3 RPROP", "M4 SCG"] {
        row("the paper's best nets", net, &|condition| share(condition, net));
    }
    for net in ["LM", "L-BFGS", "BR", "GP"] {
        row("other algorithms", net, &|condition| share(condition, net));
    }
    for net in ["M4 SCG", "BR", "GP"] {
        let by = format!("{net}, 1000 rows");
        row("more rows", &by, &|condition| share(&format!("{condition}-more"), net));
    }
    row("a genetic search", "net found by search", &|at| learned(at, "net found by search"));
    row("support vectors", "support vector regression", &|at| {
        learned(at, "support vector regression")
    });
    row("several networks", "an ensemble", &|at| learned(at, "ensemble, other starts"));
    row("other activations", "logistic, SCG", &|at| learned(at, "net, logistic, scg"));
    row("baselines", "line", &|at| learned(at, "line"));
    row("baselines", "cubic", &|at| learned(at, "cubic"));
    let best = |at: &str| Some(study.result(at)?.ceiling.within_10pct);
    row("best possible", "estimate from below", &best);
    let section = Section::new("questions", "The questions of its conclusion").with(table);
    let blocks = beyond.iter().map(|beyond| Block::from(beyond.table())).collect::<Vec<_>>();
    if blocks.is_empty() {
        return section;
    }
    section.with(Block::Folded { title: "Every learner".to_owned(), blocks })
}

fn overview(study: &Study) -> Section {
    let caption = format!(
        "Answers within 10 % of the adequate force on 2000 unseen rows, percent, mean of {} draws of rows",
        study.config.draws
    );
    let nets = NETS.iter().map(super::Net::title);
    let heads = core::iter::once("condition".to_owned()).chain(nets);
    let last = ["GP", "best possible", "± over draws (RPROP)"].map(str::to_owned);
    let heads: Vec<String> = heads.chain(last).collect();
    let mut unseen = Table::new("all-unseen", caption, &heads);
    for result in &study.results {
        let shares = result.unseen().into_iter().map(|(_, share)| Cell::Percent(share));
        let first = core::iter::once(Cell::text(result.condition.title()));
        let mut cells: Vec<Cell> = first.chain(shares).collect();
        cells.push(Cell::Percent(result.ceiling.within_10pct));
        let spread = result.nets.get(2).filter(|_| study.config.draws > 1);
        cells.push(
            spread.map_or(Cell::Empty, |net| {
                Cell::Percent(net.deviation(|s| s.unseen.within_10pct()))
            }),
        );
        unseen.push(cells);
    }
    let section = Section::new("conditions", "All conditions")
        .with(
            "v: slip speed after 2 mm; T: contact time; a: mean acceleration of the slip; F: trial force; f: adequate force, the \
             target unless ln f is named. The best possible answer is an estimate from below: the higher of the closed form and of neighbours.",
        )
        .with(unseen);
    match noise_figure(study) {
        Some(figure) => section.with(figure),
        None => section,
    }
}

/// Shares against the noise of the speed, where there are at least two conditions that differ in it alone.
fn noise_figure(study: &Study) -> Option<Figure> {
    let results: Vec<&ConditionResult> =
        study.results.iter().filter(|result| result.condition.group == Group::SpeedNoise).collect();
    if results.len() < 2 {
        return None;
    }
    let line = |of: &dyn Fn(&ConditionResult) -> f64| -> Vec<(f64, f64)> {
        results.iter().map(|r| (100.0 * r.condition.speed_noise, 100.0 * of(r))).collect()
    };
    let mut chart = Chart::new(
        "Fixed trial force: what the noise of the speed leaves",
        Axis::linear("noise of the slip speed (%)"),
        Axis::linear("unseen answers within 10 % (%)"),
    );
    for (at, net) in NETS.iter().enumerate() {
        let share = |r: &ConditionResult| {
            r.nets.get(at).map_or(f64::NAN, |n| n.mean(|s| s.unseen.within_10pct()))
        };
        chart = chart.with(Layer::line(net.title(), line(&share)));
    }
    let ceiling = line(&|r| r.ceiling.within_10pct);
    let chart = chart.with(Layer::line("best possible", ceiling).drawn_as(Mark::DashedLine));
    let caption = "v and E_sc as printed; the published test figures are 59 to 69 %.".to_owned();
    Some(Figure { id: "noise".to_owned(), caption, chart })
}

fn figures(result: &ConditionResult) -> Vec<Block> {
    let curves = NETS.iter().zip(&result.nets);
    let mut blocks: Vec<Block> = curves
        .filter_map(|(net, found)| curve_figure(result, net, found).map(Block::from))
        .collect();
    if result.condition.name != "paper" {
        blocks.push(fig_7(result).into());
    }
    blocks
}

/// Nothing where no error can stand on a logarithmic axis.
fn curve_figure(result: &ConditionResult, net: &super::Net, found: &NetResult) -> Option<Figure> {
    let points = |errors: &[f64]| -> Vec<(f64, f64)> {
        let all = found.curve.epoch.iter().zip(errors);
        all.filter(|(epoch, error)| **epoch > 0 && **error > 0.0 && error.is_finite())
            .map(|(epoch, error)| (*epoch as f64, *error))
            .collect()
    };
    let (train, test) = (points(&found.curve.train), points(&found.curve.test));
    if train.is_empty() && test.is_empty() {
        return None;
    }
    let title = format!("Fig. {}. {}: error against epoch", net.figure, net.title());
    let chart = Chart::new(title, Axis::log("epoch"), Axis::log("MSE (scaled)"))
        .with(Layer::line("training rows", train))
        .with(Layer::line("test rows", test));
    let caption =
        format!("{}. The test rows had no part in the training.", result.condition.title());
    Some(Figure { id: format!("fig-{}-{}", net.figure, result.condition.name), caption, chart })
}

/// The four nets: one that fits noise would flatten all bars.
fn fig_7(result: &ConditionResult) -> Figure {
    let of_four = || NETS.iter().zip(&result.nets).filter(|(net, _)| net.published.is_some());
    let bars = |name: &str, of: fn(&NetResult) -> f64| {
        let heights = of_four().map(|(net, found)| (net.title(), of(found)));
        Layer::bars(name, heights.collect())
    };
    let condition = result.condition.title();
    let chart = Chart::new(
        format!("Fig. 7. Mean squared error; {condition}"),
        Axis::linear(""),
        Axis::linear("MSE (scaled)"),
    )
    .with(bars("training rows", |found| found.summary.mse))
    .with(bars("test rows", |found| found.summary.test_mse));
    let caption = format!("Condition: {condition}.");
    Figure { id: format!("fig-7-{}", result.condition.name), caption, chart }
}
