use std::io;

use super::{Manifest, SWEEP, stored, terminal};
use crate::cli::OutputArgs;
use crate::cli::error::Failure;
use crate::cli::figure;
use crate::cli::finish::Finish;
use crate::cli::report as page;
use crate::cli::warnings::Warnings;
use trocar_base::warning::Warning;
use trocar_document::Study as _;
use trocar_report::html::Again;
use trocar_report::{ColumnFormat, Folder, OutputError, document_text};
use trocar_studies::sweep::{Design, DrawnCases, Rows, SweepError, SweepReport, case_tables, findings};

pub(super) struct Whole<'a> {
    pub(super) design: &'a Design,
    pub(super) canonical: &'a str,
    pub(super) manifest: Manifest,
    pub(super) rows: Rows,
    pub(super) report: Option<String>,
    pub(super) printed: Vec<Warning>,
}

pub(super) fn finish(
    folder: &Folder,
    whole: Whole<'_>,
    output: &OutputArgs,
    warnings: &Warnings,
) -> Result<(), Failure> {
    write(folder, whole, output, warnings).map_err(kept)
}

fn write(folder: &Folder, whole: Whole<'_>, output: &OutputArgs, warnings: &Warnings) -> Result<(), Failure> {
    let Whole { design, canonical, manifest, rows, report: line, printed } = whole;
    let hash = &manifest.sweep_sha256;
    folder.write(SWEEP, canonical.as_bytes())?;
    let tables = || -> Result<(), Failure> {
        let formats = [ColumnFormat::Parquet].into_iter().chain(design.csv.then_some(ColumnFormat::Csv));
        let write = |format: ColumnFormat| {
            folder.stream(&format!("cases.{format}"), |out| {
                format.write_parts(out, |part| case_tables(design, hash, &rows, part).map_err(plain))
            })
        };
        Ok(formats.into_iter().try_for_each(write)?)
    };
    let summary = || -> Result<Vec<Warning>, Failure> {
        let mut findings = findings(design, &rows)?;
        let found = findings.warnings.clone();
        findings.warnings.splice(0..0, printed);
        let cases = line.is_some().then(|| DrawnCases::of(design, &rows)).transpose()?;
        let report = SweepReport { design, hash, findings: &findings, cases: cases.as_ref() };
        let document = report.document();
        let again = |line: &String| Again {
            command: "trocar sweep",
            files: vec![(SWEEP.to_owned(), canonical.to_owned())],
            note: "Run this command in the folder of the sweep's file. --case N prints case N as a scenario.",
            line: line.clone(),
        };
        let report = line.as_ref().map(again);
        Finish { output, folder: folder.clone(), all: false, report }.write(&document)?;
        folder.write("summary.txt", document_text(&document, false).as_bytes())?;
        Ok(found)
    };
    let (tables, summary) = rayon::join(tables, summary);
    tables?;
    warnings.print(&summary?);
    folder.commit_with(stored::details(&Manifest { is_complete: true, ..manifest }))?;
    report(folder, output, "files")?;
    if line.is_some() && !output.quiet && !output.json { page::print_path(folder) } else { Ok(()) }
}

pub(super) fn report(folder: &Folder, output: &OutputArgs, files: &str) -> Result<(), Failure> {
    if output.quiet && !output.json {
        return Ok(());
    }
    let path = folder.path.join(if output.json { "summary.json" } else { "summary.txt" });
    let text = std::fs::read_to_string(&path).map_err(|source| SweepError::Io { path, source })?;
    let end = match (output.json, figures(folder)) {
        (true, _) => String::new(),
        (false, figures) => format!("{figures}{files}: {}\n", folder.path.display()),
    };
    terminal::print(&format!("{text}{end}"))
}

fn figures(folder: &Folder) -> String {
    let Some(end) = figure::file_name(&folder.figures, "") else { return String::new() };
    let entries = std::fs::read_dir(&folder.path).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|name| name.ends_with(&end)).collect();
    names.sort();
    figure::lines(&names)
}

fn kept(error: Failure) -> Failure {
    match error.error.downcast() {
        Ok(error) => {
            let OutputError::Write { path, source } = *error;
            SweepError::Io { path, source }.into()
        }
        Err(other) => Failure { error: other, ..error },
    }
}

fn plain(error: SweepError) -> io::Error {
    match error {
        SweepError::Io { source, .. } => source,
        other => io::Error::other(other),
    }
}
