//! State of the table, by what the user asks for: which rows it shows, in which order, and which one is chosen.

use crate::grippers::{Column, Member, Roster, Row, Sorting, order};

/// Time between two orders of the rows (s), unless the user wants another one: rows that leap about cannot be clicked.
const ORDER_S: f64 = 1.0;

/// What the user wants to see.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// What it is ordered by.
    pub sorting: Sorting,
    /// Words that a row must hold.
    pub filter: String,
    /// The chosen gripper.
    pub chosen: Option<Member>,
    /// The row to scroll to.
    pub reveal: Option<usize>,
    order: Vec<usize>,
    /// Rows that there were, and when (s), when they were ordered last.
    ordered: Option<(usize, f64)>,
}

impl Table {
    /// Orders the rows where that is due.
    pub(crate) fn arrange(&mut self, roster: &Roster) {
        let (rows, now_s) = (roster.rows().len(), roster.now_s());
        let due = |(count, at_s): (usize, f64)| count != rows || now_s >= at_s + ORDER_S;
        if self.ordered.is_none_or(due) {
            self.order = order(roster, self.sorting, &self.filter);
            self.ordered = Some((rows, now_s));
        }
    }

    /// Rows that are shown.
    pub(crate) const fn len(&self) -> usize {
        self.order.len()
    }

    /// The row at a place of the table.
    pub(crate) fn row<'a>(&self, roster: &'a Roster, place: usize) -> Option<&'a Row> {
        roster.rows().get(*self.order.get(place)?)
    }

    /// Orders by this column, or the other way round.
    pub(crate) fn sort(&mut self, roster: &Roster, column: Column) {
        self.sorting = self.sorting.clicked(column);
        self.again(roster);
    }

    /// Shows only rows with these words.
    pub(crate) fn filter(&mut self, roster: &Roster, filter: String) {
        self.filter = filter;
        self.again(roster);
    }

    fn again(&mut self, roster: &Roster) {
        self.ordered = None;
        self.arrange(roster);
        self.reveal = self.chosen_place(roster);
    }

    /// Chooses another gripper, so many rows further down.
    pub(crate) fn step(&mut self, roster: &Roster, by: isize) {
        match self.chosen_place(roster) {
            Some(place) => self.choose(roster, place.saturating_add_signed(by)),
            None if by < 0 => self.choose(roster, usize::MAX),
            None => self.choose(roster, 0),
        }
    }

    /// Chooses the row at this place, or the last one.
    pub(crate) fn choose(&mut self, roster: &Roster, place: usize) {
        let Some(last) = self.len().checked_sub(1) else { return };
        let place = place.min(last);
        self.chosen = self.row(roster, place).map(|row| row.member.clone());
        self.reveal = Some(place);
    }

    /// Where the chosen gripper stands; `None` where it is not shown.
    pub(crate) fn chosen_place(&self, roster: &Roster) -> Option<usize> {
        let chosen = self.chosen.as_ref()?;
        let is_it =
            |place: &usize| roster.rows().get(*place).is_some_and(|row| row.member == *chosen);
        self.order.iter().position(is_it)
    }
}
