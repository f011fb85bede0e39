# SPDX-License-Identifier: Apache-2.0
# The program from its Debian package: ./dev deb && docker build -t palpate .
# docker run --rm -v "$PWD/out:/data/out" palpate pick --object mug --seed 2
# packaging/try_packages.py runs these lines without Docker.
FROM debian:bookworm-slim
COPY build/deb/palpate_0.1.0_amd64.deb /tmp/palpate.deb
RUN apt-get update \
 && apt-get install -y --no-install-recommends /tmp/palpate.deb \
 && rm -rf /tmp/palpate.deb /var/lib/apt/lists/*
RUN useradd --create-home palpate && install -d -o palpate /data
USER palpate
WORKDIR /data
ENTRYPOINT ["palpate"]
CMD ["doctor"]
