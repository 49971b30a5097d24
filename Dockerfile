# docker build -t stiction .
# docker run --rm -v "$PWD:/work" stiction solve case.toml
FROM rust:1.95-slim-bookworm AS build
RUN apt-get update && apt-get install -y --no-install-recommends gcc libc6-dev && rm -rf /var/lib/apt/lists/*
WORKDIR /source
COPY . .
RUN cargo build --locked --release -p stiction-cli

FROM debian:bookworm-slim
COPY --from=build /source/target/release/stiction /usr/local/bin/
COPY LICENSE-MIT LICENSE-APACHE THIRD-PARTY-LICENSES.txt /usr/local/share/doc/stiction/
WORKDIR /work
ENTRYPOINT ["stiction"]
