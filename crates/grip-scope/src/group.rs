//! The plots in which channels belong: the title of each.

slip_msg::named! {
    /// Which plot a channel belongs in.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
    pub enum Group {
        fn name: "Title of the plot.";
    }
    Stylus: "The styli.", "stylus";
    Bands: "Energies of the detector's bands.", "bands";
    Statistic: "Evidence of a slip.", "slip evidence";
    Force: "Forces.", "force";
    Esc: "E_sc with its enclosure.", "E_sc";
    Motion: "Travel and slip speed.", "travel and speed";
    Reference: "Motion reference and commanded motion.", "motion reference";
    Pressure: "The static pressure.", "pressure";
}
