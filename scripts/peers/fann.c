/* The networks, rows and starting weights that the bench `peers` wrote, trained and run with FANN. Prints
 * NAME <tab> VALUE <tab> UNIT, the least of several rounds. */
#include <fann.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void die(const char *what)
{
    fprintf(stderr, "fann: %s\n", what);
    exit(1);
}

static void set_functions(struct fann *net)
{
    fann_set_activation_function_hidden(net, FANN_SIGMOID_SYMMETRIC);
    fann_set_activation_function_output(net, FANN_LINEAR);
    fann_set_activation_steepness_hidden(net, 1.0F);
    fann_set_activation_steepness_output(net, 1.0F);
    fann_set_training_algorithm(net, FANN_TRAIN_RPROP);
    // The squared error, as ours; its default is tanh of the error.
    fann_set_train_error_function(net, FANN_ERRORFUNC_LINEAR);
    fann_set_rprop_delta_zero(net, 0.07F);
}

static void load(struct fann *net, const char *path)
{
    unsigned int count = fann_get_total_connections(net);
    struct fann_connection *links = calloc(count, sizeof *links);
    FILE *file = fopen(path, "r");
    if (links == NULL || file == NULL)
        die(path);
    fann_get_connection_array(net, links);
    for (unsigned int i = 0; i < count; i++)
        if (fscanf(file, "%f", &links[i].weight) != 1)
            die("too few weights");
    fann_set_weight_array(net, links, count);
    fclose(file);
    free(links);
}

static void train(const char *directory, const char *name, unsigned int sizes[3], int epochs)
{
    char path[4096];
    double least = 1e9;
    float mse = 0.0F;
    snprintf(path, sizeof path, "%s/%s.data", directory, name);
    struct fann_train_data *data = fann_read_train_from_file(path);
    if (data == NULL)
        die(path);
    snprintf(path, sizeof path, "%s/%s.weights", directory, name);
    for (int round = 0; round < 7; round++) {
        struct fann *net = fann_create_standard_array(3, sizes);
        set_functions(net);
        load(net, path);
        double start = now();
        for (int epoch = 0; epoch < epochs; epoch++)
            mse = fann_train_epoch(net, data);
        double each = (now() - start) / epochs;
        least = each < least ? each : least;
        fann_destroy(net);
    }
    printf("fann rprop %s\t%.4f\tus/epoch\n", name, least * 1e6);
    printf("fann rprop %s mse\t%.6f\t-\n", name, (double)mse);
    fann_destroy_train(data);
}

static void forward(const char *name, unsigned int layers, unsigned int *sizes)
{
    struct fann *net = fann_create_standard_array(layers, sizes);
    float input[64];
    double through = 1e9, latency = 1e9;
    volatile float sink = 0.0F;
    set_functions(net);
    fann_randomize_weights(net, -0.5F, 0.5F);
    for (unsigned int i = 0; i < sizes[0]; i++)
        input[i] = 0.25F;
    for (int round = 0; round < 3000; round++) {
        /* Short rounds: on a busy machine some are not interrupted. */
        const int calls = 400;
        double start = now();
        for (int i = 0; i < calls; i++)
            sink = *fann_run(net, input);
        double each = (now() - start) / calls;
        through = each < through ? each : through;
        start = now();
        for (int i = 0; i < calls; i++)
            input[0] = *fann_run(net, input) * 0.5F;
        each = (now() - start) / calls;
        latency = each < latency ? each : latency;
    }
    (void)sink;
    printf("fann forward %s throughput\t%.4f\tns\n", name, through * 1e9);
    printf("fann forward %s latency\t%.4f\tns\n", name, latency * 1e9);
    fann_destroy(net);
}

int main(int argc, char **argv)
{
    unsigned int surface[] = {2, 10, 1}, building[] = {14, 16, 3}, kinematics[] = {32, 16, 1};
    unsigned int deep[] = {16, 32, 16, 1};
    if (argc != 2)
        die("usage: fann DIRECTORY");
    train(argv[1], "surface2", surface, 2000);
    train(argv[1], "building1", building, 40);
    train(argv[1], "kin32fm", kinematics, 40);
    forward("2-10-1", 3, surface);
    forward("16-32-16-1", 4, deep);
    return 0;
}
