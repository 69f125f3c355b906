//! Page of a case in Markdown.
//!
//! The page begins with one sentence with the verdict, the first plot and a summary of the figures
//! that decide. Setting, all figures, further plots and runs are below.

use super::case::Case;
use super::case_report::{CaseResult, FigureResult, RunLine, value_text};
use super::schema::CaseFile;
use super::verdict::{Verdict, band_text};
use sphecs_core::format::{duration, grouped, significant};

/// Most figures in the summary.
const SUMMARY: usize = 10;

/// Numbers of criteria of a case.
#[derive(Clone, Copy, Debug, Default)]
struct Criteria {
    /// Measured figures with a required band, or without the value that they must have.
    required: usize,
    missed: usize,
    goals: usize,
    reached: usize,
    /// Required bands whose figures were not measured.
    not_measured: usize,
    runs: usize,
    /// Runs that failed without permission.
    failed: usize,
}

impl Criteria {
    fn of(file: &CaseFile, result: &CaseResult) -> Self {
        let count = |holds: &dyn Fn(&FigureResult) -> bool| {
            result.figures.iter().filter(|measured| holds(measured)).count()
        };
        let must = |measured: &FigureResult| file.figures[measured.index].must.is_some();
        Self {
            required: count(&|measured| must(measured) || measured.verdict == Verdict::Missed),
            missed: count(&|measured| measured.verdict == Verdict::Missed),
            goals: count(&|measured| file.figures[measured.index].goal.is_some()),
            reached: count(&|measured| measured.verdict == Verdict::Goal),
            not_measured: result.not_measured.len(),
            runs: result.runs.len(),
            failed: result.runs.iter().filter(|run| run.failure.is_some() && !run.may_fail).count(),
        }
    }

    /// Returns the verdict on the case, as in `**met** (2 of 2 required bands met)`.
    fn verdict(self) -> String {
        let Self { required, missed, goals, reached, not_measured, runs, failed } = self;
        let word = if missed + failed > 0 {
            "missed"
        } else if reached < goals {
            "goals open"
        } else if required + goals > 0 {
            "met"
        } else {
            return "**informational** (no figure has a criterion)".to_owned();
        };
        let some = |count: usize, text: String| (count > 0).then_some(text);
        let parts = [
            some(missed, format!("{missed} of {required} required bands missed")),
            some(required, format!("{required} of {required} required bands met")).filter(|_| missed == 0),
            some(goals, format!("{reached} of {goals} goals reached")),
            some(not_measured, format!("{not_measured} required but not measured")),
            some(failed, format!("{failed} of {runs} runs failed")),
        ];
        format!("**{word}** ({})", parts.into_iter().flatten().collect::<Vec<_>>().join(", "))
    }
}

/// Returns the rank of a figure in the summary: misses, required bands, goals, then figures that
/// the case names. None for all others.
fn rank(file: &CaseFile, measured: &FigureResult) -> Option<u8> {
    let figure = &file.figures[measured.index];
    match measured.verdict {
        Verdict::Missed => Some(0),
        _ if figure.must.is_some() => Some(1),
        _ if figure.goal.is_some() => Some(2),
        _ if figure.in_summary => Some(3),
        _ => None,
    }
}

/// Returns the figures of the summary, those of one rank in the order of the case.
fn summary<'a>(file: &CaseFile, result: &'a CaseResult) -> Vec<&'a FigureResult> {
    let ranked = result.figures.iter().filter_map(|measured| Some((rank(file, measured)?, measured)));
    let mut ranked: Vec<_> = ranked.collect();
    ranked.sort_by_key(|(rank, _)| *rank);
    ranked.into_iter().take(SUMMARY).map(|(_, measured)| measured).collect()
}

/// Returns the page of a case; `command` reproduces it.
pub fn page(case: &Case, result: &CaseResult, command: &str) -> String {
    let file = &case.file;
    let compared =
        file.compared_with.as_ref().map_or(String::new(), |with| format!(", compared with {with}"));
    let verdict = Criteria::of(file, result).verdict();
    let mut text = format!("# {}\n\n{}{compared}: {verdict}.\n", file.title, file.title);
    let (first, further) = result.plots.split_at(result.plots.len().min(1));
    text += &drawings(first);
    text += &summary_section(file, result);
    text += &format!("\n## Setting\n{}\n\nSource: {}.\n", file.setting.trim(), file.source);
    if summary(file, result).len() < result.figures.len() {
        text += &format!("\n## All figures\n{}", table(file, result.figures.iter()));
    }
    text += &not_measured_line(file, result);
    if !further.is_empty() {
        text += &format!("\n## Further plots\n{}", drawings(further));
    }
    text += &runs_section(&result.runs, command);
    if let Some(remarks) = &file.remarks {
        text += &format!("\n## Remarks\n{}\n", remarks.trim());
    }
    text
}

fn drawings(plots: &[(String, String)]) -> String {
    plots.iter().map(|(path, title)| format!("\n![{title}]({path})\n")).collect()
}

/// Returns the summary and a sentence on the figures that it omits.
fn summary_section(file: &CaseFile, result: &CaseResult) -> String {
    let listed = summary(file, result);
    let all = result.figures.len();
    let with_criterion = |measured: &&FigureResult| rank(file, measured).is_some_and(|rank| rank < 3);
    let criteria = result.figures.iter().filter(with_criterion).count();
    let mut text = "\n## Summary\n".to_owned();
    if !listed.is_empty() {
        text += &format!("{}\n", table(file, listed.iter().copied()));
    }
    let shown = listed.len();
    text += &match criteria {
        0 if shown == 0 => "No figure has a criterion.".to_owned(),
        0 => "No figure has a criterion; these are the main ones.".to_owned(),
        _ if shown < criteria => format!("These are {shown} of the {criteria} figures with a criterion."),
        _ if shown > criteria => {
            "These are the figures with a criterion and the main ones without.".to_owned()
        }
        _ => "These are the figures with a criterion.".to_owned(),
    };
    text += &if shown < all {
        format!(" [All {all} figures](#all-figures) are below.\n")
    } else {
        "\n".to_owned()
    };
    text
}

/// Returns a table of figures.
fn table<'a>(file: &CaseFile, figures: impl Iterator<Item = &'a FigureResult>) -> String {
    let mut text =
        "| figure | measured | required | goal | published | |\n|---|---|---|---|---|---|\n".to_owned();
    for measured in figures {
        let figure = &file.figures[measured.index];
        let band = |band: &Option<_>| band.as_ref().map_or(String::new(), band_text);
        let printed = figure.printed.map_or(String::new(), |printed| significant(printed.value));
        // A vertical bar would end the cell.
        text += &format!(
            "| {} | {} | {} | {} | {printed} | {} |\n",
            figure.what.replace('|', "\\|"),
            value_text(measured),
            band(&figure.must),
            band(&figure.goal),
            measured.verdict.word()
        );
    }
    text
}

/// Returns a line on required figures that were not measured.
fn not_measured_line(file: &CaseFile, result: &CaseResult) -> String {
    if result.not_measured.is_empty() {
        return String::new();
    }
    let what: Vec<&str> =
        result.not_measured.iter().map(|&index| file.figures[index].what.as_str()).collect();
    format!(
        "\nRequired but not measured, because the runs belong to another tier or have no results: {}.\n",
        what.join("; ").replace('|', "\\|")
    )
}

/// Returns the table of runs, their notes and the command that reproduces them.
fn runs_section(runs: &[RunLine], command: &str) -> String {
    let mut text =
        "\n## Runs\n| run | scene | particles | steps | wall time |\n|---|---|---|---|---|\n".to_owned();
    for run in runs {
        let sets: Vec<String> = run.set.iter().map(|(path, value)| format!("`{path}={value}`")).collect();
        let with = if sets.is_empty() { String::new() } else { format!(" with {}", sets.join(", ")) };
        let took = match &run.failure {
            Some(failure) => format!("failed: {failure}"),
            None => duration(run.wall_time),
        };
        let (particles, steps) = (grouped(run.particles), grouped(run.steps));
        text += &format!("| {} | `{}`{with} | {particles} | {steps} | {took} |\n", run.name, run.scene);
    }
    let earlier: Vec<&str> =
        runs.iter().filter(|run| run.of_another_build).map(|run| run.name.as_str()).collect();
    if !earlier.is_empty() {
        text += &format!("\nReused from another build of this version: {}.\n", earlier.join(", "));
    }
    for run in runs.iter().filter(|run| !run.notes.is_empty()) {
        text += &format!("\nNotes of `{}`: {}.\n", run.name, run.notes.join("; "));
    }
    if let Some(run) = runs.first() {
        let threads = match run.threads {
            1 => "1 thread".to_owned(),
            count => format!("{count} threads with as many concurrent runs"),
        };
        text += &format!("\n{threads}, {} lanes. To reproduce:\n", run.lanes);
    }
    text + &format!("```sh\n{command}\n```\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{shipped, shipped_text};
    use crate::measures::measurement::Measurement;

    /// Returns a case with figures of the given bands, and its results with the given values.
    fn results(figures: &[(&str, &str, f64)]) -> (Case, CaseResult) {
        let list: String = figures
            .iter()
            .map(|(name, bands, _)| {
                format!(r#"(name: "{name}", what: "{name}", {bands} value: Formula("1")),"#)
            })
            .collect();
        let text = format!(
            r#"Case(title: "Stream", source: "nobody", compared_with: "a pipe", setting: "It flows.",
            remarks: "None.", runs: [(name: "a", scene: "couette")], figures: [{list}])"#
        );
        let case = Case::read("stream", &text, None).expect("no faults");
        let mut result = CaseResult::default();
        for (index, (file, (_, _, value))) in case.file.figures.iter().zip(figures).enumerate() {
            let verdict = Verdict::on(Some(*value), file.must.as_ref(), file.goal.as_ref());
            result.figures.push(FigureResult { index, value: Ok(Measurement::plain(*value)), verdict });
        }
        (case, result)
    }

    const MUST: &str = "must: AtMost(1.0),";
    const GOAL: &str = "goal: AtMost(1.0),";

    #[test]
    fn summary_has_misses_then_required_bands_then_goals() {
        let figures = [
            ("plain", "", 0.0),
            ("named", "in_summary: true,", 0.0),
            ("goal", GOAL, 2.0),
            ("met", MUST, 0.5),
            ("missed", MUST, 2.0),
            ("both", "must: AtMost(3.0), goal: AtMost(1.0),", 2.0),
        ];
        let (case, result) = results(&figures);
        let listed = summary(&case.file, &result);
        let names: Vec<&str> =
            listed.iter().map(|found| case.file.figures[found.index].what.as_str()).collect();
        assert_eq!(names, ["missed", "met", "both", "goal", "named"]);
    }

    #[test]
    fn summary_has_at_most_ten_rows_with_the_misses() {
        let figures: Vec<(&str, &str, f64)> =
            (0..12).map(|index| ("same", MUST, if index == 11 { 2.0 } else { 0.0 })).collect();
        let names: Vec<String> = (0..12).map(|index| format!("figure_{index}")).collect();
        let figures: Vec<_> = names
            .iter()
            .zip(figures)
            .map(|(name, (_, bands, value))| (name.as_str(), bands, value))
            .collect();
        let (case, result) = results(&figures);
        let indices: Vec<usize> = summary(&case.file, &result).iter().map(|found| found.index).collect();
        assert_eq!(indices, [11, 0, 1, 2, 3, 4, 5, 6, 7, 8]);
        let page = page(&case, &result, "");
        assert!(page.contains("These are 10 of the 12 figures with a criterion. [All 12 figures]"), "{page}");
    }

    #[test]
    fn page_begins_with_verdict_plot_and_summary() {
        let (case, mut result) = results(&[("plain", "", 0.0), ("met", MUST, 0.5)]);
        result.plots = ["first", "second"].map(|name| (format!("{name}.svg"), name.to_owned())).into();
        let page = page(&case, &result, "sphecs validate");
        let begin = "# Stream\n\nStream, compared with a pipe: **met** (1 of 1 required bands met).\n\n\
                     ![first](first.svg)\n\n## Summary\n| figure | measured |";
        assert!(page.starts_with(begin), "{page}");
        let headings: Vec<&str> = page.lines().filter(|line| line.starts_with("## ")).collect();
        assert_eq!(
            headings,
            ["## Summary", "## Setting", "## All figures", "## Further plots", "## Runs", "## Remarks"]
        );
        let at = |words: &str| page.find(words).expect(words);
        assert!(at("| met | 0.5 | ≤ 1 |  |  | met |") < at("## Setting"), "{page}");
        assert!(at("## All figures") < at("| plain | 0 |"), "{page}");
        assert!(at("## Further plots\n\n![second](second.svg)") < at("## Runs"), "{page}");
    }

    #[test]
    fn complete_summary_is_not_repeated() {
        let (case, result) = results(&[("met", MUST, 0.5)]);
        let page = page(&case, &result, "");
        assert!(page.contains("These are the figures with a criterion.\n\n## Setting"), "{page}");
        assert!(!page.contains("All figures") && !page.contains("Further plots"), "{page}");
    }

    #[test]
    fn verdict_counts_the_criteria() {
        let verdict = |figures: &[(&str, &str, f64)]| {
            let (case, result) = results(figures);
            Criteria::of(&case.file, &result).verdict()
        };
        assert_eq!(verdict(&[("a", "", 0.0)]), "**informational** (no figure has a criterion)");
        assert_eq!(
            verdict(&[("a", MUST, 0.0), ("b", GOAL, 2.0)]),
            "**goals open** (1 of 1 required bands met, 0 of 1 goals reached)"
        );
        assert_eq!(
            verdict(&[("a", MUST, 2.0), ("b", MUST, 0.0), ("c", GOAL, 0.0)]),
            "**missed** (1 of 2 required bands missed, 1 of 1 goals reached)"
        );
        let (case, mut result) = results(&[("a", MUST, 0.0)]);
        result.not_measured.push(0);
        assert_eq!(
            Criteria::of(&case.file, &result).verdict(),
            "**met** (1 of 1 required bands met, 1 required but not measured)"
        );
    }

    #[test]
    fn shipped_cases_name_their_reference_and_at_most_ten_main_figures() {
        for name in shipped() {
            let file = shipped_text(&name).expect("no faults").file;
            assert!(file.compared_with.is_some(), "{name}: state `compared_with`");
            let main = file.figures.iter().filter(|figure| figure.in_summary).count();
            assert!(main <= SUMMARY, "{name}: {main} main figures");
        }
    }
}
