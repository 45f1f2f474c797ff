# facetloc's tools and Python module: docker build -t facetloc . && docker run -v "$PWD:/data" facetloc facetloc_check /data/walk
FROM debian:12 AS build
COPY . /facetloc
WORKDIR /facetloc
RUN cmake/install_dependencies.sh help2man && cmake -B /build -G Ninja -DFACETLOC_BUILD_TESTS=OFF && cmake --build /build && cd /build && cpack
FROM debian:12
COPY --from=build /build/*.deb /packages/
RUN apt-get update && apt-get install -y --no-install-recommends /packages/*.deb && rm -rf /packages /var/lib/apt/lists/*
WORKDIR /data
CMD ["facetloc_map", "--help"]
