pub(crate) fn run<T>(_: &T) -> anyhow::Result<grip_host::exit::Exit> {
    anyhow::bail!("temporary")
}
