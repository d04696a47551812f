//! The problems of three papers, run and compared number by number and figure by figure. A paper is a module.

mod andersen;
mod buzzi;
mod tielen;

use super::problem::{Problem, Study};

/// The study of the papers.
pub const STUDY: Study = Study {
    name: "papers",
    title: "The papers, number by number",
    text: "Every number that is not marked as the paper's was computed by that command. Figures of the papers are known to us by their \
           captions and by what the text says of them; a finding is that sentence, judged by our numbers.",
    heads: ["figure", "the paper says", "we see"],
    problems,
};

fn problems() -> Vec<Problem> {
    tielen::problems().into_iter().chain(andersen::problems()).chain(buzzi::problems()).collect()
}
