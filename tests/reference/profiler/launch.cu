// Runs stages that `cargo run --release --workspace --example stages` wrote: each once, under a profiler. Prints how many of the words that are
// kept of each output are those of the CPU; the rest differ where a fast kernel rounds otherwise.
#include "metal.cuh"
#include "kernels.cuh"
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#define CHECK(call)                                                                    \
    do {                                                                               \
        const cudaError_t error = (call);                                              \
        if (error != cudaSuccess) {                                                    \
            fprintf(stderr, "%s: %s\n", #call, cudaGetErrorString(error));             \
            exit(1);                                                                   \
        }                                                                              \
    } while (0)

static std::vector<char> file(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) {
        fprintf(stderr, "cannot read %s\n", path.c_str());
        exit(1);
    }
    return {std::istreambuf_iterator<char>(in), {}};
}

// A line of stages.txt: technique, kernel, lanes, groups, then access, bytes and file of each buffer.
int main(int, char** argv) {
    const std::string folder = argv[1];
    std::ifstream list(folder + "/stages.txt");
    for (std::string line; std::getline(list, line);) {
        std::istringstream words(line);
        std::string technique, kernel, access, name;
        unsigned lanes, groups, bytes;
        words >> technique >> kernel >> lanes >> groups;
        Arguments arguments = {};
        struct Output { unsigned binding; std::string name; };
        std::vector<Output> outputs;
        for (unsigned binding = 0; words >> access >> bytes >> name; binding++) {
            const std::vector<char> data = access == "Out" ? std::vector<char>() : file(folder + "/" + name);
            if (access == "One") {
                if (data.size() > sizeof arguments.one[0]) {
                    fprintf(stderr, "%s: a record of %zu bytes\n", kernel.c_str(), data.size());
                    return 1;
                }
                memcpy(arguments.one[binding], data.data(), data.size());
                continue;
            }
            arguments.bytes[binding] = bytes;
            CHECK(cudaMalloc(&arguments.buffer[binding], bytes));
            CHECK(cudaMemset(arguments.buffer[binding], 0, bytes));
            if (access == "In") CHECK(cudaMemcpy(arguments.buffer[binding], data.data(), bytes, cudaMemcpyHostToDevice));
            if (access == "Out") outputs.push_back({binding, name});
        }
        const Entry* entry = nullptr;
        for (const Entry& each : KERNELS)
            if (kernel == each.name) entry = &each;
        if (entry == nullptr) {
            fprintf(stderr, "%s was not translated\n", kernel.c_str());
            return 1;
        }
        entry->run<<<groups, lanes>>>(arguments);
        CHECK(cudaGetLastError());
        CHECK(cudaDeviceSynchronize());
        printf("%s %s:", technique.c_str(), kernel.c_str());
        for (const Output& output : outputs) {
            const std::vector<char> expected = file(folder + "/" + output.name);
            std::vector<char> found(expected.size());
            CHECK(cudaMemcpy(found.data(), arguments.buffer[output.binding], found.size(), cudaMemcpyDeviceToHost));
            size_t same = 0;
            for (size_t i = 0; i < found.size(); i += 4) same += memcmp(&found[i], &expected[i], 4) == 0;
            printf(" %zu of %zu", same, found.size() / 4);
        }
        printf("\n");
        fflush(stdout);
        for (void* buffer : arguments.buffer) CHECK(cudaFree(buffer));
    }
}
