//! The sentences of the source study that many draws can decide, and what is measured for each.

use super::{Claim, Kept, SIMILAR, similar};
use crate::study::NETS;

pub(super) const CLAIMS: [Claim; 19] = [
    Claim {
        place: "IV.B",
        claim: "a larger learning rate makes gradient descent unstable",
        measured: "at the largest rate of the sweep the error of most starts rises, at the smallest it never does",
        holds: |draw| {
            let (first, last) = (draw.sweep.first()?, draw.sweep.last()?);
            Some(last.unstable > 0.5 && first.unstable == 0.0)
        },
    },
    Claim {
        place: "IV.B",
        claim: "a smaller learning rate takes long",
        measured: "the smallest rate of the sweep ends at twice the error of the best rate or more",
        holds: |draw| Some(draw.sweep.first()?.mse >= 2.0 * draw.best_rate()),
    },
    Claim {
        place: "IV.B",
        claim: "plain gradient descent is too slow",
        measured: "M1 ends at twice the training error of M4 or more",
        holds: |draw| Some(draw.nets[0].mse >= 2.0 * draw.nets[3].mse),
    },
    Claim {
        place: "IV.B",
        claim: "momentum converges faster (averaged form)",
        measured: "M2 reaches the last error of M1 in 4/5 of the epochs or less",
        holds: |draw| Some(draw.over_m1(&draw.nets[1])? <= 1.0 / SIMILAR),
    },
    Claim {
        place: "IV.B",
        claim: "momentum converges faster (heavy ball)",
        measured: "the same of M2 with the heavy ball",
        holds: |draw| Some(draw.over_m1(&draw.heavy)? <= 1.0 / SIMILAR),
    },
    Claim {
        place: "IV.B",
        claim: "descent may be stuck in a shallow local minimum, momentum gets over it",
        measured: "where most starts of M1 have come to rest: the heavy ball ends at 4/5 of its error or less",
        holds: |draw| {
            let rest = draw.nets[0].still_falling <= 0.5;
            rest.then(|| draw.heavy.mse <= draw.nets[0].mse / SIMILAR)
        },
    },
    Claim {
        place: "IV.B",
        claim: "RPROP converges much faster than M1 and M2",
        measured: "M3 reaches the last error of M1 in a fifth of the epochs or less, and that of M2 too",
        holds: |draw| {
            let ratio = draw.over_m1(&draw.nets[2])?;
            let m2 = draw.nets[2].epochs_to(draw.nets[1].mse).unwrap_or(usize::MAX);
            Some(ratio <= 0.2 && m2 <= draw.nets[1].history.len() / 5)
        },
    },
    Claim {
        place: "Figs. 3-6",
        claim: "M1, M2 and M3 end at the last epoch, M4 at the error goal",
        measured: "the goal given; without one, some goal does it: M4 ends below the three others",
        holds: |draw| Some(draw.m4_alone_reaches_a_goal()),
    },
    Claim {
        place: "Fig. 7",
        claim: "M3 has the lowest training error",
        measured: "below M1, M2 and M4",
        holds: |draw| Some(draw.m3_has_the_lowest_training_error()),
    },
    Claim {
        place: "Figs. 3-7",
        claim: "both: M4 alone reaches the goal, and M3 has the lowest training error",
        measured: "the two above at once (with one goal for all nets they exclude each other)",
        holds: |draw| {
            Some(draw.m4_alone_reaches_a_goal() && draw.m3_has_the_lowest_training_error())
        },
    },
    Claim {
        place: "Fig. 7",
        claim: "M3 has a test error far above its training error and that of the others: low generalisation",
        measured: "the largest test error of the four, and a quarter or more above its training error",
        holds: |draw| {
            let [m1, m2, m3, m4] = &draw.nets;
            let largest = [m1, m2, m4].iter().all(|net| m3.test_mse() > net.test_mse());
            Some(largest && m3.test_mse() >= SIMILAR * m3.train_mse())
        },
    },
    Claim {
        place: "Fig. 7",
        claim: "test errors of M1, M2 and M4 differ little",
        measured: "the largest is at most a quarter above the least",
        holds: |draw| {
            let [m1, m2, _, m4] = &draw.nets;
            Some(similar(&[m1, m2, m4].map(Kept::test_mse)))
        },
    },
    Claim {
        place: "Fig. 7",
        claim: "of M1, M2 and M4 the last has the lowest training error",
        measured: "M4 below M1 and M2",
        holds: |draw| {
            let [m1, m2, _, m4] = &draw.nets;
            Some(m4.train_mse() < m1.train_mse().min(m2.train_mse()))
        },
    },
    Claim {
        place: "Fig. 7",
        claim: "training and test error differ alike in M1 and M2",
        measured: "the differences have one sign, and the larger is at most a quarter above the smaller",
        holds: |draw| {
            let gap = |net: &Kept| net.test_mse() - net.train_mse();
            let (a, b) = (gap(&draw.nets[0]), gap(&draw.nets[1]));
            Some(a * b > 0.0 && similar(&[a.abs(), b.abs()]))
        },
    },
    Claim {
        place: "Table 2",
        claim: "training rows right: M3 before M4, M1 and M2",
        measured: "in this order, answers within 10 %",
        holds: |draw| Some(draw.by_table_2(Kept::train_share)),
    },
    Claim {
        place: "Table 2",
        claim: "test rows right: M3 before M4, M1 and M2",
        measured: "in this order, answers within 10 % of 60 rows",
        holds: |draw| Some(draw.by_table_2(Kept::test_share)),
    },
    Claim {
        place: "Table 2",
        claim: "more of the test rows right than of the training rows, for each net",
        measured: "for all four, answers within 10 %",
        holds: |draw| Some(draw.nets.iter().all(|net| net.test_share() > net.train_share())),
    },
    Claim {
        place: "Table 2",
        claim: "the shares themselves: 51-63 % of the training rows, 59-69 % of the test rows",
        measured: "the study does not say when an answer is right",
        holds: |_| None,
    },
    Claim {
        place: "Conclusions",
        claim: "60-70 % of the test rows right",
        measured: "so says Table 2 of each net (M2 has 58.92 % there)",
        holds: |_| {
            let mut tests = NETS.iter().filter_map(|net| net.published);
            Some(tests.all(|[_, test]| (0.6..=0.7).contains(&test)))
        },
    },
];
