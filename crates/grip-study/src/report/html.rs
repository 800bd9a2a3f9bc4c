//! A report in, one HTML page out.

use super::{Block, Cell, Report, Table};
use grip_plot::PlotError;

const STYLE: &str = "\
body{font:16px/1.5 'DejaVu Sans',Verdana,sans-serif;color:#222;max-width:66rem;margin:2rem auto;padding:0 1rem}\
h1{font-size:1.6rem}h2{font-size:1.25rem;margin-top:2.5rem;border-bottom:1px solid #bbb}\
h3{font-size:1rem;margin:1.2rem 0 .2rem}\
table{border-collapse:collapse;font-size:.85rem;margin:.4rem 0 1.2rem}\
caption{text-align:left;font-weight:bold;padding:.4rem 0}\
th,td{padding:.15rem .6rem;border-bottom:1px solid #ddd;text-align:right;font-variant-numeric:tabular-nums}\
th{vertical-align:bottom;background:#f3f3f3}td.text,th.text{text-align:left}\
.wide{overflow-x:auto}figure{margin:1rem 0}figure svg{max-width:100%;height:auto}\
figcaption{font-size:.85rem;color:#444}\
details{margin:.5rem 0;border-left:3px solid #ddd;padding-left:.8rem}summary{cursor:pointer}\
.summary{background:#f3f7fb;border:1px solid #cbd9e6;padding:.2rem 1rem}nav ol{columns:2;font-size:.9rem}";

pub(super) fn page(report: &Report) -> Result<String, PlotError> {
    let title = escaped(&report.title);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
    );
    if !report.summary.is_empty() {
        page.push_str("<div class=\"summary\">\n");
        report.summary.iter().for_each(|text| page.push_str(&paragraph(text)));
        page.push_str("</div>\n");
    }
    page.push_str("<nav><ol>\n");
    for section in &report.sections {
        let (id, title) = (escaped(&section.id), escaped(&section.title));
        page.push_str(&format!("<li><a href=\"#{id}\">{title}</a></li>\n"));
    }
    page.push_str("</ol></nav>\n");
    for section in &report.sections {
        let (id, title) = (escaped(&section.id), escaped(&section.title));
        page.push_str(&format!("<section id=\"{id}\">\n<h2>{title}</h2>\n"));
        for block in &section.blocks {
            add(&mut page, block)?;
        }
        page.push_str("</section>\n");
    }
    page.push_str("</body>\n</html>\n");
    Ok(page)
}

fn add(page: &mut String, block: &Block) -> Result<(), PlotError> {
    match block {
        Block::Heading(title) => page.push_str(&format!("<h3>{}</h3>\n", escaped(title))),
        Block::Text(text) => page.push_str(&paragraph(text)),
        Block::Table(table) => page.push_str(&table_html(table)),
        Block::Figure(figure) => {
            let (id, caption) = (escaped(&figure.id), escaped(&figure.caption));
            let svg = own_names(figure.chart.svg()?.trim(), &id);
            page.push_str(&format!("<figure id=\"{id}\">\n{svg}\n"));
            page.push_str(&format!("<figcaption>{caption}</figcaption>\n</figure>\n"));
        }
        Block::Folded { title, blocks } => {
            page.push_str(&format!("<details>\n<summary>{}</summary>\n", escaped(title)));
            for block in blocks {
                add(page, block)?;
            }
            page.push_str("</details>\n");
        }
    }
    Ok(())
}

/// Names inside a chart (of its clip paths) count for the whole page, so each chart gets its own.
fn own_names(svg: &str, id: &str) -> String {
    svg.replace(" id=\"", &format!(" id=\"{id}-")).replace("url(#", &format!("url(#{id}-"))
}

fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escaped(text))
}

fn table_html(table: &Table) -> String {
    let mut html = format!(
        "<div class=\"wide\"><table id=\"{}\">\n<caption>{}</caption>\n<thead><tr>",
        escaped(&table.id),
        escaped(&table.caption)
    );
    let words = |column: usize| {
        table.rows.iter().all(|row| matches!(row.get(column), Some(Cell::Text(_)) | None))
    };
    for (at, head) in table.columns.iter().enumerate() {
        let class = if words(at) { " class=\"text\"" } else { "" };
        html.push_str(&format!("<th{class}>{}</th>", escaped(head)));
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        html.push_str("<tr>");
        row.iter().for_each(|cell| html.push_str(&cell_html(cell)));
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table></div>\n");
    html
}

fn cell_html(cell: &Cell) -> String {
    let shown = escaped(&cell.shown());
    match cell {
        Cell::Text(_) => format!("<td class=\"text\">{shown}</td>"),
        Cell::Empty => format!("<td>{shown}</td>"),
        Cell::Number(_) | Cell::Percent(_) | Cell::Count(_) => {
            format!("<td data-value=\"{}\">{shown}</td>", cell.json())
        }
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
